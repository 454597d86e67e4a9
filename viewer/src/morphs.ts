// A plant that moves by morph targets: shapes of it that are added up.
import type {AnimationClip} from 'three';
import {rowAt, type Movement, type Player, type Shape} from './movement';
import type {Facts, PlantMesh} from './loop';

export class Morphs implements Movement {
  readonly shapes: Shape[];
  readonly windLimit: number;
  readonly windHint: string;
  private readonly times: ArrayLike<number>;   // [s] keys, 0 … period
  private readonly weights: ArrayLike<number>;  // keys x targets

  // `timeShifts` [s]: for each mesh how far its instance is ahead of the clip.
  constructor(private readonly meshes: PlantMesh[], private readonly timeShifts: number[], clip: AnimationClip | undefined,
              private readonly facts: Facts) {
    const {targetKinds = [], targetModes = []} = meshes[0].userData as {targetKinds?: Shape['kind'][]; targetModes?: number[]};
    this.shapes = targetKinds.map((kind, i) => ({
      kind, mode: targetModes[i], frequency: targetModes[i] > 0 ? facts.frequencies_hz[targetModes[i] - 1] : 0,
    }));
    const scales = facts.scales !== false;
    this.windLimit = scales ? 2 : 1;
    this.windHint = scales ?
        'Loads grow with the square of the wind speed, and so do lean and swaying here; the frequencies stay.' :
        'This flaps by itself, and in another wind otherwise: here its motion is only made smaller.';
    this.times = clip?.tracks[0].times ?? [0];
    this.weights = clip?.tracks[0].values ?? [];
  }

  windText(wind: number): string {
    const speed = this.facts.wind_speed_m_s;
    return speed > 0 ? `${(wind * speed).toFixed(1)} m/s` : `${wind.toFixed(2)}×`;
  }

  shownText(): string { return ''; }

  show(player: Player): number[] {
    this.meshes.forEach((mesh, i) => {
      const weights = this.weightsAt(player, this.timeShifts[i]);
      mesh.morphTargetInfluences?.splice(0, weights.length, ...weights);
    });
    return this.weightsAt(player, 0).map((weight) => 2 * weight);  // weights span 1
  }

  // Loads grow with the square of the wind speed, the mean one and (for a given intensity of turbulence) the
  // fluctuating one; the answer is linear in the loads.
  private weightsAt(player: Player, timeShift: number): number[] {
    const load = player.wind * player.wind;
    return rowAt(this.times, this.weights, this.shapes.length, player.time + timeShift)
        .map((weight, i) => player.enabled[i] ? load * weight : 0);
  }
}
