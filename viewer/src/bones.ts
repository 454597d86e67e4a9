// A plant that moves by bones: its clips are blended as any engine does, and its modes are small turns of the joints.
import {
  AnimationMixer, Quaternion, Vector3, type AnimationAction, type AnimationClip, type BufferAttribute, type Object3D,
  type Skeleton, type SkinnedMesh,
} from 'three';
import {rowAt, type Movement, type Player, type Shape} from './movement';

// Vectors of all joints under each shape, in whole numbers of a step for each shape.
interface ShapeVectors { accessor: number; steps: number[] }

export interface ShapeFacts {
  clip: number;  // whose shapes they are
  kinds: Shape['kind'][];
  frequencies_hz: number[];
  weights: number;  // accessor: samples x shapes, 1 for as far as a shape goes
  turns: ShapeVectors;
  travels: ShapeVectors;
}
export interface ClipFacts { name: string; wind_speed_m_s: number }

type ReadAccessor = (index: number) => Promise<BufferAttribute>;

// By shape and joint, [rad] or [m].
async function readVectors(vectors: ShapeVectors, read: ReadAccessor): Promise<Vector3[][]> {
  const all = await read(vectors.accessor);
  const joints = all.count / vectors.steps.length;
  return vectors.steps.map((step, c) => Array.from({length: joints}, (_, j) => {
    const i = c * joints + j;
    return new Vector3(all.getX(i), all.getY(i), all.getZ(i)).multiplyScalar(step);
  }));
}

export class ShapeTable {
  private constructor(readonly shapes: Shape[], readonly clip: number, readonly weights: ArrayLike<number>,
                      readonly turns: Vector3[][], readonly travels: Vector3[][]) {}

  static async read(facts: ShapeFacts, read: ReadAccessor): Promise<ShapeTable> {
    let mode = 0;
    const shapes = facts.kinds.map((kind, c) => ({
      kind, mode: kind === 'mode' ? ++mode : 0, frequency: facts.frequencies_hz[c],
    }));
    return new ShapeTable(shapes, facts.clip, (await read(facts.weights)).array,
                          await readVectors(facts.turns, read), await readVectors(facts.travels, read));
  }
}

function turnBy(vector: Vector3, target: Quaternion): Quaternion {
  const angle = vector.length();
  return angle > 0 ? target.setFromAxisAngle(vector.clone().divideScalar(angle), angle) : target.identity();
}

// One plant's joints, and where they rest.
interface Joints { skeleton: Skeleton; rest: Vector3[]; timeShift: number }

export class Bones implements Movement {
  readonly windLimit = 1;
  readonly windHint: string;
  readonly shapes: Shape[];
  private readonly mixer: AnimationMixer;
  private readonly stages: {speed: number; name: string; action?: AnimationAction}[];  // still air, then by wind speed
  private readonly joints: Joints[];
  private readonly times: number[];      // of the rows of the shapes' weights
  private readonly shapesSpeed: number;  // [m/s] of the clip whose shapes they are
  private inspected = false;

  // `timeShifts` [s]: for each mesh how far its instance is ahead of the first.
  constructor(private readonly root: Object3D, meshes: SkinnedMesh[], timeShifts: number[], clips: AnimationClip[],
              facts: ClipFacts[], private readonly table: ShapeTable | undefined,
              private readonly repeats: boolean) {
    this.shapes = table?.shapes ?? [];
    this.shapesSpeed = table ? facts[table.clip].wind_speed_m_s : 0;
    const all = new Map(meshes.map((mesh, i) => [mesh.skeleton.bones[0], {
      skeleton: mesh.skeleton, rest: mesh.skeleton.bones.map((bone) => bone.position.clone()), timeShift: timeShifts[i],
    }]));
    this.joints = [...all.values()];
    this.mixer = new AnimationMixer(root);
    const actions = clips.map((clip, i) => ({
      speed: facts[i].wind_speed_m_s, name: facts[i].name, action: this.mixer.clipAction(clip).play(),
    }));
    actions.sort((a, b) => a.speed - b.speed);
    this.stages = actions.length > 0 && actions[0].speed === 0 ? actions : [{speed: 0, name: 'still air'}, ...actions];
    const period = clips.reduce((longest, clip) => Math.max(longest, clip.duration), 0);
    const rows = table ? table.weights.length / table.shapes.length : 0;
    this.times = Array.from({length: rows + 1}, (_, i) => rows > 0 ? i * period / rows : 0);
    const names = this.stages.map(({name, speed}) => speed > 0 ? `${name} (${Number(speed.toFixed(2))} m/s)` : name);
    this.windHint = `In the file: ${names.slice(1).join(', ') || names[0]}. What is between is blended, joint by joint, `
        + 'by the square of the wind speed.';
  }

  windText(wind: number): string {
    return this.strongest === 0 || wind === 0 ? 'still air' : `${(wind * this.strongest).toFixed(1)} m/s`;
  }

  shownText(wind: number): string {
    const {low, high, part} = this.between(wind);
    const name = (stage: Bones['stages'][0]): string => stage.action ? `${stage.name} (${Number(stage.speed.toFixed(2))} m/s)` : stage.name;
    const percent = Math.round(100 * part);
    return part === 1 ? name(high) : part === 0 ? name(low) : `${percent} % ${name(high)}, ${100 - percent} % ${name(low)}`;
  }

  show(player: Player): number[] {
    const weights = this.weightsAt(player.time);
    // Shapes that are looked at one by one are small turns about the lean; all together they are the clip.
    const inspect = this.shapes.some((_, c) => !player.enabled[c]);
    if (inspect) this.joints.forEach((joints) => { this.inspect(joints, player); });
    else this.play(player);
    this.inspected = inspect;
    this.root.updateMatrixWorld(true);
    const load = this.loadOfShapes(player.wind);
    return weights.map((weight, c) => player.enabled[c] ? load * weight : 0);
  }

  private get strongest(): number { return this.stages[this.stages.length - 1].speed; }

  private weightsAt(time: number): number[] {
    return this.table ? rowAt(this.times, this.table.weights, this.shapes.length, time, this.repeats) : [];
  }

  // Neighbours in the file, and how far it is from the one to the other: loads go with the square of the speed.
  private between(wind: number): {low: Bones['stages'][0]; high: Bones['stages'][0]; part: number} {
    const load = (wind * this.strongest) ** 2;
    const above = Math.max(this.stages.findIndex(({speed}) => speed ** 2 >= load * (1 - 1e-12)), 0);
    const high = this.stages[above], low = this.stages[Math.max(above - 1, 0)];
    const way = high.speed ** 2 - low.speed ** 2;
    return {low, high, part: way > 0 ? Math.min((load - low.speed ** 2) / way, 1) : 1};
  }

  private play(player: Player): void {
    if (this.inspected) {
      // The mixer writes what it thinks has changed.
      for (const {action} of this.stages) action?.setEffectiveWeight(0);
      this.mixer.setTime(player.time);
      for (const {skeleton, rest} of this.joints) skeleton.bones.forEach((bone, j) => {
        bone.position.copy(rest[j]);
        if (j > 0) bone.quaternion.identity();
      });
    }
    const {low, high, part} = this.between(player.wind);
    for (const {action} of this.stages) action?.setEffectiveWeight(0);
    low.action?.setEffectiveWeight(1 - part);
    high.action?.setEffectiveWeight(part);
    this.mixer.setTime(player.time);
  }

  private loadOfShapes(wind: number): number {
    return this.shapesSpeed > 0 ? (wind * this.strongest / this.shapesSpeed) ** 2 : wind * wind;
  }

  private inspect({skeleton, rest, timeShift}: Joints, player: Player): void {
    const {turns, travels, shapes} = this.table!;
    const load = this.loadOfShapes(player.wind);
    const weights = this.weightsAt(player.time + timeShift).map((weight, c) => player.enabled[c] ? load * weight : 0);
    const turn = new Vector3(), part = new Quaternion();
    skeleton.bones.forEach((bone, j) => {
      if (j === 0) return;
      bone.quaternion.identity();
      bone.position.copy(rest[j]);
      turn.set(0, 0, 0);
      shapes.forEach(({kind}, c) => {
        bone.position.addScaledVector(travels[c][j], weights[c]);
        if (kind === 'lean') bone.quaternion.copy(turnBy(turns[c][j].clone().multiplyScalar(weights[c]), part));
        else turn.addScaledVector(turns[c][j], weights[c]);
      });
      bone.quaternion.multiply(turnBy(turn, part));
    });
  }
}
