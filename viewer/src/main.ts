// Plays the loop that the page carries, at any instant and in any wind up to the strongest it knows.
import './style.css';
import {hasLetters} from './block';
import {readDrift} from './drift';
import {readGrass} from './grass';
import {readImpressions} from './impressions';
import {readLoop, unpack, type Loop, type PlantMesh} from './loop';
import {dress} from './materials';
import type {Player} from './movement';
import {Panel} from './panel';
import {Stage} from './stage';
import {readVolume} from './volume';

// For scripts and tests. Positions are in metres with z up, as in every other file.
interface Tremula {
  ready: Promise<void>;
  period: number;
  vertexCount: number;
  meshes: PlantMesh[];
  setTime(seconds: number): void;
  pause(): void;
  vertex(index: number): [number, number, number];  // in the frame on the screen
  branchOf(index: number): number;
  alongOf(index: number): number;
}

declare global {
  interface Window { tremula: Partial<Tremula> & Pick<Tremula, 'ready'>; }
}

// Of what is no glTF, by its first letters.
const readers: Record<string, (data: ArrayBuffer) => Loop> = {TRMG: readGrass, TRMD: readDrift, TRMI: readImpressions, TRMV: readVolume};

async function start(): Promise<void> {
  const data = document.getElementById('loop')!;
  const bytes = await unpack(data.textContent!);
  data.remove();
  const reader = Object.entries(readers).find(([letters]) => hasLetters(bytes, letters))?.[1] ?? readLoop;
  const loop = await reader(bytes);
  if (!loop.field) dress(loop.meshes);

  const period = loop.facts.period_s;
  const player: Player = {
    playing: !matchMedia('(prefers-reduced-motion: reduce)').matches,
    time: 0,
    speed: 1,
    wind: 1,
    enabled: loop.movement.shapes.map(() => true),
  };
  const canvas = document.getElementById('stage') as HTMLCanvasElement;
  const stage = new Stage(canvas, loop);

  let changed = true;
  const panel = new Panel(loop, player, () => { changed = true; });
  const draw = (): void => {
    panel.show(loop.movement.show(player));
    stage.render();
    changed = false;
  };

  let last = performance.now();
  const tick = (now: number): void => {
    // A page that was hidden goes on where it stopped; the first frame may be stamped before its own start.
    const passed = Math.min(Math.max((now - last) / 1000, 0), 0.1);
    last = now;
    if (player.playing && period > 0) player.time = (player.time + passed * player.speed) % period;
    // Nothing is drawn while nothing moves.
    if (stage.moveCamera() || player.playing || changed) draw();
    requestAnimationFrame(tick);
  };
  new ResizeObserver(() => { stage.resize(); draw(); }).observe(canvas);
  draw();
  requestAnimationFrame(tick);

  const {vertices} = loop;
  Object.assign(window.tremula, {
    period,
    vertexCount: vertices.count,
    meshes: loop.meshes,
    setTime: (seconds: number) => { player.time = seconds; draw(); },
    pause: () => { player.playing = false; draw(); },
    vertex: (index: number) => {
      if (changed) draw();
      return vertices.position(index, stage.renderer);
    },
    branchOf: (index: number) => vertices.branch(index),
    alongOf: (index: number) => vertices.along(index),
  });
}

window.tremula = {ready: start()};
window.tremula.ready.catch((reason: unknown) => {
  const message = document.getElementById('message')!;
  message.textContent = `This page cannot show its plant: ${reason instanceof Error ? reason.message : String(reason)}`;
  message.hidden = false;
});
