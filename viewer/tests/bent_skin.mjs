// The program's own pose of every vertex, worked out here from its tables of nodes: a cubic through both ends of each
// branch in their directions carries its cross sections.
import {execFileSync} from 'node:child_process';
import {Quaternion, Vector3} from 'three';
import {parsePoses, program} from './support.mjs';

const vector = (numbers) => new Vector3(...numbers);

function turnOf(rotation) {
  const angle = Math.hypot(...rotation);
  return angle === 0 ? new Quaternion() : new Quaternion().setFromAxisAngle(vector(rotation).divideScalar(angle), angle);
}

const printed = (words) => execFileSync(program, words, {encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'],
                                                        maxBuffer: 1 << 26});

// Where the nodes are at a frame, in a wind of this speed.
export function poseOf(preset, speed, frame, framesPerSecond) {
  const flags = Object.entries({'wind-speed': speed, fps: framesPerSecond, frames: frame, format: 'csv'})
                    .flatMap(([flag, value]) => [`--${flag}`, String(value)]);
  return parsePoses(printed(['animate', preset, '-o', '-', ...flags]))[frame];
}

// Where each branch of a preset begins, and which node carries that place. Nodes: roots, then ends of branches.
export function readBranches(preset) {
  const lines = printed(['grow', preset, '-o', '-']).split('\n').filter((line) => line && !line.startsWith('#'))
                    .map((line) => line.trim().split(/\s+/).map(Number));
  const places = new Map(lines.map(([id, type, x, y, z, , parent]) => [id, {type, at: [x, y, z], parent}]));
  const nodes = [...places].filter(([, {type}]) => type === 1).concat([...places].filter(([, {type}]) => type === 2));
  const number = new Map(nodes.map(([id], i) => [id, i]));
  return nodes.filter(([, {type}]) => type === 2).map(([id, {at, parent}]) => {
    const start = places.get(parent);
    return {start: start.at, end: at, carrier: number.get(start.type === 16 ? start.parent : parent), node: number.get(id)};
  });
}

export function bentCurve({start, end, carrier, node}, rest, pose) {
  const carried = turnOf(pose.turns[carrier]);
  const from = vector(start).sub(vector(rest[carrier])).applyQuaternion(carried).add(vector(pose.nodes[carrier]));
  const to = vector(pose.nodes[node]), length = from.distanceTo(to), turned = turnOf(pose.turns[node]);
  const direction = vector(end).sub(vector(start)).normalize();
  return {start, end, from, to, carried, turned, direction,
          leaves: direction.clone().applyQuaternion(carried).multiplyScalar(length),
          arrives: direction.clone().applyQuaternion(turned).multiplyScalar(length)};
}

// What the cross section at s carries.
export function carriedBy(curve, s, point) {
  const {start, end, from, to, carried, turned, direction, leaves, arrives} = curve;
  const sum = (a, b, c, d) => new Vector3().addScaledVector(from, a).addScaledVector(leaves, b).addScaledVector(to, c)
                                  .addScaledVector(arrives, d);
  const place = sum(1 - 3 * s * s + 2 * s ** 3, s - 2 * s * s + s ** 3, 3 * s * s - 2 * s ** 3, s ** 3 - s * s);
  const slope = sum(6 * s * s - 6 * s, 1 - 4 * s + 3 * s * s, 6 * s - 6 * s * s, 3 * s * s - 2 * s).normalize();
  const between = carried.clone().slerp(turned, s);
  const into = new Quaternion().setFromUnitVectors(direction.clone().applyQuaternion(between), slope);
  const arm = vector(point).sub(vector(start).lerp(vector(end), s));
  return arm.applyQuaternion(into.multiply(between)).add(place).toArray();
}
