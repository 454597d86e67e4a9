// What drifts: one small mesh of every material, drawn as often as any are seen. The shader does what make_loop of the
// library does (src/tremula/deformation/drift_pose.cpp): it finds the path that a mesh shows, where on it that is, and how
// it is turned. What the page holds is described in src/tremula/io/drift_page.hpp.
import {
  Box3, BufferAttribute, Color, DoubleSide, FrontSide, Group, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  MeshStandardMaterial, SRGBColorSpace, Vector2, Vector3, type WebGLRenderer,
} from 'three';
import {
  grouped, lightThrough, mostRows, numbersOf, PosedVertices, readBlock, shadowMaterial, texelShader, texture, wordsOfThings,
  type Part, type Uniforms,
} from './block';
import type {Facts, Loop, PlantMesh} from './loop';
import type {Movement, Player, Shape} from './movement';

type Form = 'flake' | 'drop' | 'leaf' | 'seed';

interface Material { name: string; color_srgb: [number, number, number]; roughness: number; meshes: number }

interface Header {
  name: string;
  facts: Facts;
  form: Form;
  low_m: [number, number, number];
  high_m: [number, number, number];
  ground_m: number;
  step_s: number;
  settling_s: number;
  seen: number;   // at a time, in the mean
  share: number;  // of all that there were
  mesh: {vertices: number[][]; triangles: number[]};  // position and normal
  materials: Material[];
  meshes: Part;
  stays: Part & {words: number};
  samples: Part;
}

const exposure = 1 / 60;  // of the camera that sees drops as streaks [s]
const turnsOf = (form: Form): boolean => form === 'leaf' || form === 'seed';

// poseDrift gives a vertex of the small mesh that shows the stays first to last: [m], z up.
const poseShader = ({form, settling_s: settling, stays: {words}}: Header): string => /* glsl */ `
  uniform highp usampler2D driftStays;
  uniform highp isampler2D driftSamples;
  uniform float driftNow, driftPeriod, driftStep, driftGround;
  ${texelShader}

  struct Drifting { vec3 place, velocity; float size, age, airTime; bool lies; };

  vec4 stayWords(int stay, int four) {
    return uintBitsToFloat(texelFetch(driftStays, texelOf(${words / 4} * stay + four), 0));
  }

  // Which stay its mesh shows, and the time in the loop that this begins in.
  int stayOf(vec2 stays, out float since) {
    int first = int(stays.x), last = int(stays.y), stay = last;
    while (stay != first && stayWords(stay, 0).x > driftNow) --stay;
    since = driftNow;
    if (stayWords(stay, 0).x > driftNow) {
      stay = last;
      since += driftPeriod;
    } else if (stay == last && stayWords(first, 0).x + driftPeriod <= driftNow) {
      stay = first;
      since -= driftPeriod;
    }
    return stay;
  }

  Drifting driftingOf(int stay, float since) {
    vec4 when = stayWords(stay, 0), start = stayWords(stay, 1), line = stayWords(stay, 2);
    uvec4 own = texelFetch(driftStays, texelOf(${words / 4} * stay + 3), 0);
    Drifting d;
    d.age = since - when.w;
    d.airTime = line.w;
    d.size = since >= when.y && since < when.z ? uintBitsToFloat(own.x) : 0.0;
    d.lies = uintBitsToFloat(own.z) > 0.5;
    float within = clamp(d.age, 0.0, d.airTime), position = within / driftStep;
    int interval = max(min(int(position), int(ceil(d.airTime / driftStep)) - 1), 0), sampled = int(own.w) + interval;
    float t = position - float(interval);
    vec4 weights = vec4(((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0,
                        ((-1.5 * t + 2.0) * t + 0.5) * t, (0.5 * t - 0.5) * t * t);
    vec4 slopes = vec4((-1.5 * t + 2.0) * t - 0.5, (4.5 * t - 5.0) * t, (-4.5 * t + 4.0) * t + 0.5, (1.5 * t - 1.0) * t);
    vec3 off = vec3(0), drift = vec3(0);
    for (int i = 0; i < 4; ++i) {
      vec3 s = vec3(texelFetch(driftSamples, texelOf(sampled + i), 0).xyz);
      off += weights[i] * s;
      drift += slopes[i] * s;
    }
    d.place = start.xyz + within * line.xyz + start.w * off;
    d.velocity = d.age < d.airTime ? line.xyz + start.w / driftStep * drift : vec3(0);
    if (d.age > d.airTime && d.lies) d.place.z = driftGround;
    return d;
  }
  ${turnsOf(form) ? /* glsl */ `
  const float turn = 6.283185307179586;

  // Where a vertex of size 1 and a normal go.
  void turnDrifting(int stay, inout Drifting d, inout vec3 at, inout vec3 facing) {
    vec4 a = stayWords(stay, 4), b = stayWords(stay, 5);
    float left = clamp((d.airTime - d.age) / ${settling.toFixed(6)}, 0.0, 1.0), flying = d.lies ? left * left * (3.0 - 2.0 * left) : 1.0;
    float phase = a.x + a.y * d.age, spun = a.w * min(d.age, d.airTime);
    phase -= turn * floor(phase / turn + 0.5);
    float yaw = a.z + spun - turn * floor(spun / turn);
    float tilt = flying * (b.w > 0.5 ? phase : b.x * sin(phase)), lean = flying * b.z;
    mat3 about = mat3(cos(yaw), sin(yaw), 0, -sin(yaw), cos(yaw), 0, 0, 0, 1) *
        mat3(cos(tilt), 0, -sin(tilt), 0, 1, 0, sin(tilt), 0, cos(tilt)) *
        mat3(1, 0, 0, 0, cos(lean), sin(lean), 0, -sin(lean), cos(lean));
    at = about * at;
    facing = about * facing;
    d.place -= flying * b.y * cos(phase) * vec3(cos(yaw), sin(yaw), 0);
  }` : 'void turnDrifting(int stay, inout Drifting d, inout vec3 at, inout vec3 facing) {}'}
`;

// ---- How it looks

// What is smaller than so many pixels is drawn as large, and as much fainter, but not below a share: else far ones would
// be nothing, as in a photograph.
const looks: Record<Form, {pixels: number; faintest: number}> = {
  flake: {pixels: 3.4, faintest: 0.5},
  drop: {pixels: 1.4, faintest: 0.16},
  leaf: {pixels: 3, faintest: 1},
  seed: {pixels: 5, faintest: 1},
};

const drawShader = (form: Form): string => /* glsl */ `
  attribute vec2 thing;
  uniform vec2 driftPicture;  // its height [pixels]; how long the shutter is open [s]
  varying float driftAlpha;
  varying vec2 driftOff;  // its middle, in sizes
  varying vec3 driftTint;
  float driftHash(float n) { return fract(sin(n) * 43758.5453); }

  void drawDrift(vec3 at, inout vec3 facing, mat4 view, mat4 projection, out vec3 place) {
    float since;
    int stay = stayOf(thing, since);
    Drifting d = driftingOf(stay, since);
    turnDrifting(stay, d, at, facing);
    float depth = max(-(view * vec4(d.place, 1)).z, 1e-3);
    float pixel = 2.0 * depth / (projection[1][1] * driftPicture.x);
    float size = d.size > 0.0 ? max(d.size, ${looks[form].pixels.toFixed(2)} * pixel) : 0.0;
    float seen = d.size > 0.0 ? d.size / size : 0.0;
    place = d.place + size * at;
    driftAlpha = max(seen * seen, ${looks[form].faintest.toFixed(2)});
    ${form === 'drop' ? /* glsl */ `
    float speed = length(d.velocity), streak = speed * driftPicture.y;
    if (speed > 0.0) place += 0.5 * driftPicture.y * d.velocity * clamp(dot(normalize(at), d.velocity) / speed, -1.0, 1.0);
    driftAlpha = max(seen * d.size / (d.size + streak), ${looks[form].faintest.toFixed(2)});` : ''}
    ${form === 'flake' ? /* glsl */ `
    // Light comes out of a flake wherever it came in: it is as bright all over, and soft at its edge.
    driftOff = (view * vec4(at, 0)).xy;
    facing = vec3(0, 0, 1);` : ''}
    float bright = driftHash(0.731 * float(stay)), warm = driftHash(1.317 * float(stay) + 5.0) - 0.5;
    driftTint = ${turnsOf(form) ? '(0.75 + 0.5 * bright) * vec3(1.0 + 0.3 * warm, 1.0, 1.0 - 0.3 * warm)' : 'vec3(1)'};
  }
`;

function driftMaterial({name, color_srgb, roughness}: Material, form: Form, pose: string, uniforms: Uniforms): MeshStandardMaterial {
  const round = !turnsOf(form);
  const material = new MeshStandardMaterial({
    name, roughness, side: round ? FrontSide : DoubleSide, color: new Color().setRGB(...color_srgb, SRGBColorSpace),
    transparent: round, depthWrite: !round,
  });
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
        .replace('void main() {', `${pose}${drawShader(form)}\nvoid main() {`)
        .replace('#include <beginnormal_vertex>', `
          vec3 driftPlace, objectNormal = normal;
          drawDrift(position, objectNormal, modelViewMatrix, projectionMatrix, driftPlace);`)
        .replace('#include <begin_vertex>', 'vec3 transformed = driftPlace;');
    shader.fragmentShader = shader.fragmentShader
        .replace('void main() {', 'varying float driftAlpha;\nvarying vec2 driftOff;\nvarying vec3 driftTint;\nvoid main() {')
        .replace('#include <color_fragment>', `
          diffuseColor *= vec4(driftTint, driftAlpha);
          ${form === 'flake' ? 'diffuseColor.a *= 1.0 - smoothstep(0.25, 0.45, length(driftOff));' : ''}`)
        .replace('#include <opaque_fragment>', round ? '#include <opaque_fragment>' : lightThrough('vec3(0.35, 0.30, 0.12)'));
  };
  return material;
}

function geometryOf({vertices, triangles}: Header['mesh'], stays: Float32Array): InstancedBufferGeometry {
  const geometry = new InstancedBufferGeometry();
  const three = (from: number): BufferAttribute =>
    new BufferAttribute(Float32Array.from(vertices.flatMap((vertex) => vertex.slice(from, from + 3))), 3);
  geometry.setAttribute('position', three(0));
  geometry.setAttribute('normal', three(3));
  geometry.setAttribute('thing', new InstancedBufferAttribute(stays, 2));
  geometry.setIndex(triangles);
  geometry.instanceCount = stays.length / 2;
  return geometry;
}

// ---- What is read

// Three numbers in four, since textures of three are not to be had.
function padded(samples: Int16Array, count: number): Int16Array {
  const result = new Int16Array(4 * count);
  for (let i = 0; i < count; ++i) result.set(samples.subarray(3 * i, 3 * i + 3), 4 * i);
  return result;
}

// Of every mesh its first and last stay, by material.
function staysOf(first: Uint32Array, materials: Material[]): Float32Array[] {
  let mesh = 0;
  return materials.map(({meshes}) => {
    const stays = new Float32Array(2 * meshes);
    for (let i = 0; i < meshes; ++i, ++mesh) stays.set([first[mesh], first[mesh + 1] - 1], 2 * i);
    return stays;
  });
}

class Drifts implements Movement {
  readonly shapes: Shape[] = [];
  readonly windLimit = 0;
  readonly windHint = '';

  constructor(private readonly header: Header, private readonly uniforms: Uniforms) {}

  windText(): string { return ''; }

  shownText(): string {
    const {facts: {wind_speed_m_s: speed}, share} = this.header;
    const paths = `in the wind of ${speed.toFixed(1)} m/s, which made these paths`;
    return share < 1 ? `${paths} · ${(100 * share).toPrecision(2)} % of their number` : paths;
  }

  show({time, speed}: Player): number[] {
    const {period_s: period} = this.header.facts;
    this.uniforms.driftNow.value = time - period * Math.floor(time / period);
    this.uniforms.driftPicture.value.y = speed * exposure;
    return [];
  }
}

const words: Record<Form, string> = {flake: 'flakes', drop: 'drops', leaf: 'leaves', seed: 'seeds'};

export function readDrift(data: ArrayBuffer): Loop {
  const {header, first} = readBlock<Header>(data);
  const {form, facts, stays, samples, meshes, materials, low_m, high_m, ground_m} = header;
  const uniforms: Uniforms = {
    driftStays: {value: texture(wordsOfThings(numbersOf(Uint32Array, data, first, stays, stays.words), stays.count), 4)},
    driftSamples: {value: texture(padded(numbersOf(Int16Array, data, first, samples, 3), samples.count), 4)},
    driftNow: {value: 0},
    driftPeriod: {value: facts.period_s},
    driftStep: {value: header.step_s},
    driftGround: {value: ground_m},
    driftPicture: {value: new Vector2(1000, exposure)},
  };
  const pose = poseShader(header);
  const byMaterial = staysOf(numbersOf(Uint32Array, data, first, {...meshes, count: meshes.count + 1}), materials);
  const root = new Group();
  root.rotation.x = -Math.PI / 2;  // from z up to y up
  const drawn: PlantMesh[] = [];
  const size = new Vector2();
  const shadow = shadowMaterial(uniforms, `${pose}\nattribute vec2 thing;`, `
    float since;
    int stay = stayOf(thing, since);
    Drifting d = driftingOf(stay, since);
    vec3 transformed = position, facing = normal;
    turnDrifting(stay, d, transformed, facing);
    transformed = d.place + d.size * transformed;`);
  materials.forEach((material, i) => {
    const mesh = new Mesh(geometryOf(header.mesh, byMaterial[i]), driftMaterial(material, form, pose, uniforms));
    mesh.customDepthMaterial = shadow;
    mesh.onBeforeRender = (renderer: WebGLRenderer) => { uniforms.driftPicture.value.x = renderer.getDrawingBufferSize(size).y; };
    drawn.push(mesh);
    root.add(mesh);
  });
  root.updateMatrixWorld(true);
  return {
    name: header.name, facts, root, meshes: drawn, movement: new Drifts(header, uniforms),
    vertices: new PosedVertices(byMaterial.map((things) => ({vertices: header.mesh.vertices, things, width: 2})), uniforms, pose, `
      float since;
      int stay = stayOf(thing, since);
      Drifting d = driftingOf(stay, since);
      vec3 at = position, facing = normal;
      turnDrifting(stay, d, at, facing);
      place = d.place + d.size * at;`),
    field: {
      extent: new Box3(new Vector3(low_m[0], ground_m, -high_m[1]), new Vector3(high_m[0], high_m[2], -low_m[1])),
      textureRows: mostRows(uniforms), castsShadow: turnsOf(form), told: `${grouped(header.seen)} ${words[form]}`,
      weather: form === 'flake' ? 'snow' : form === 'drop' ? 'rain' : 'fair', view: 'through',
    },
  };
}
