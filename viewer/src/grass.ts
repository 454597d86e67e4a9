// A meadow: one blade of every kind, drawn as often as it stands there, and moved by the response field of its make,
// which the graphics card reads as a texture. The shader does what pose_grass (src/tremula/deformation) does; what
// the page holds is described in src/tremula/io/grass_page.hpp.
import {
  Box3, BufferAttribute, Color, DoubleSide, FrontSide, Group, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  MeshStandardMaterial, PlaneGeometry, SRGBColorSpace, Vector2, Vector3, Vector4,
} from 'three';
import {
  grouped, lightThrough, mostRows, numbersOf, PosedVertices, readBlock, shadowMaterial, texelShader, texture, travelling,
  travellingShader, wordsOfThings, type FieldAxes, type Part, type Uniforms,
} from './block';
import type {Facts, Loop, PlantMesh} from './loop';
import {InFieldWind} from './movement';

interface Make { response: number; lean_rad: number; per_length: number; step_rad: number }

interface Kind {
  name: string;
  color_srgb: [number, number, number];
  two_sided: boolean;
  shares: number[];  // lengths of its pieces, of 1
  // Joint, across, out, normal across, normal out, u, along.
  skin: {vertices: number[][]; triangles: number[]};
  makes: Make[];
  bends: {first: number; in_plane: number; across: number};
}

interface Header {
  name: string;
  facts: Facts;
  height_m: number;
  field: FieldAxes;
  blades: Part & {
    low_m: [number, number, number]; step_m: [number, number, number];
    length_step_m: number; width_step_m: number;
  };
  responses: Part;
  bends: Part;
  kinds: Kind[];
}

const mostKinds = 8, makesPerKind = 3;
const mostWithShadows = 500_000;  // which pose every blade twice a frame

// Everything that the shader needs to know of a blade by its number. poseBlade gives a vertex of it, by where the vertex
// is about the joints of the blade: [m], z up.
const poseShader = /* glsl */ `
  ${texelShader}
  ${travellingShader}
  uniform Travelling grassField;
  uniform highp usampler2D grassBlades;
  uniform highp sampler2D grassResponses, grassBends;
  uniform vec3 grassLow, grassStep;
  uniform vec2 grassSizeSteps;
  uniform float grassNow, grassLoad, grassBladeHeight;
  uniform vec4 grassShares[${mostKinds}];
  uniform vec4 grassKinds[${mostKinds}];                   // pieces, first bend, entries in the plane and across
  uniform vec4 grassMakes[${mostKinds * makesPerKind}];  // response or -1, lean, per length, step of the angles

  struct Blade {
    vec3 foot;
    float length, width, attached;
    vec2 azimuth, facing;
    int kind, trajectory, make, stem;
  };
  struct Directions { vec4 x, y, z; };  // of four pieces

  vec2 turned(uint part, float parts) {
    float angle = float(part) * (6.283185307179586 / parts);
    return vec2(cos(angle), sin(angle));
  }

  Blade bladeOf(int i) {
    uvec4 r = texelFetch(grassBlades, texelOf(i), 0);
    Blade b;
    b.foot = grassLow + grassStep * vec3(r.x & 0xffffu, r.x >> 16, r.y & 0xffffu);
    b.length = grassSizeSteps.x * float(r.y >> 16);
    b.azimuth = turned(r.z & 0x3fffu, 16384.0);
    b.facing = turned((r.z >> 14) & 0x3ffu, 1024.0);
    b.width = grassSizeSteps.y * float(r.z >> 24);
    b.attached = (float(r.w & 0x3ffu) - 1.0) / 1022.0;
    b.kind = int((r.w >> 10) & 7u);
    b.trajectory = int((r.w >> 13) & 15u);
    b.make = ${makesPerKind} * b.kind + int((r.w >> 17) & 3u);
    b.stem = i - int(r.w >> 19);
    return b;
  }

  // Along x and y.
  vec2 anglesOf(Blade b) {
    vec4 make = grassMakes[b.make];
    if (make.x < 0.0) return vec2(0);
    int first = int(make.x) * int(grassField.samples) * int(grassField.columns);
    vec2 gusts = travellingAt(grassResponses, first, grassField, b.foot.xy, grassNow).xy;
    return fromWind(grassField, grassLoad * b.length * make.z * (vec2(make.y, 0) + make.w * gusts));
  }

  Directions bendAt(int entry) {
    return Directions(texelFetch(grassBends, texelOf(3 * entry), 0), texelFetch(grassBends, texelOf(3 * entry + 1), 0),
                      texelFetch(grassBends, texelOf(3 * entry + 2), 0));
  }

  // In the blade's own axes, at angles in its plane and across.
  Directions bent(Blade b, float inPlane, float across) {
    vec4 kind = grassKinds[b.kind];
    int first = int(kind.y);
    if (kind.z < 1.5) return bendAt(first + b.trajectory);
    int columns = int(kind.z), rows = int(kind.w);
    float shrink = 1.0 / (1.0 + sqrt(inPlane * inPlane + across * across));
    float u = (inPlane * shrink + 1.0) * 0.5 * (kind.z - 1.0), v = abs(across) * shrink * (kind.w - 1.0);
    int column = min(int(u), columns - 2), row = min(int(v), rows - 2);
    float s = u - float(column), t = v - float(row);
    int entry = first + (b.trajectory * rows + row) * columns + column;
    Directions a = bendAt(entry), c = bendAt(entry + 1), d = bendAt(entry + columns), e = bendAt(entry + columns + 1);
    Directions found = Directions(mix(mix(a.x, c.x, s), mix(d.x, e.x, s), t), mix(mix(a.y, c.y, s), mix(d.y, e.y, s), t),
                                  mix(mix(a.z, c.z, s), mix(d.z, e.z, s), t));
    vec4 unit = inversesqrt(found.x * found.x + found.y * found.y + found.z * found.z + 1e-12);
    found.x *= unit;
    found.y *= across < 0.0 ? -unit : unit;
    found.z *= unit;
    return found;
  }

  Directions standing(Blade b) {
    vec2 a = anglesOf(b), q = b.azimuth;
    Directions d = bent(b, q.x * a.x + q.y * a.y, q.x * a.y - q.y * a.x);
    return Directions(q.x * d.x - q.y * d.y, q.y * d.x + q.x * d.y, d.z);
  }

  vec3 endOf(vec3 foot, vec4 laid, Directions d) { return foot + vec3(dot(laid, d.x), dot(laid, d.y), dot(laid, d.z)); }

  // Puts a blade on its stem: the turn of z to the piece t there, without a twist.
  void attach(inout Blade b, inout Directions d) {
    Blade stem = bladeOf(b.stem);
    Directions of = standing(stem);
    vec4 shares = grassShares[stem.kind];
    vec4 starts = vec4(0, shares.x, shares.x + shares.y, shares.x + shares.y + shares.z);
    b.foot = endOf(stem.foot, stem.length * clamp(b.attached - starts, vec4(0), shares), of);
    int piece = int(b.attached > starts.y) + int(b.attached > starts.z) + int(b.attached > starts.w);
    vec3 t = vec3(of.x[piece], of.y[piece], of.z[piece]);
    vec4 share = (d.x * t.x + d.y * t.y + d.z * (1.0 + t.z)) / max(1.0 + t.z, 1e-3), twice = 2.0 * d.z;
    d.x += (twice - share) * t.x;
    d.y += (twice - share) * t.y;
    d.z += twice * t.z - share * (1.0 + t.z);
  }

  // \`about\`: the joint, and how far from it along the flat side and out of it; \`facing\`: the normal there.
  void poseBlade(int i, vec3 about, vec2 facing, out vec3 place, out vec3 normalThere) {
    Blade b = bladeOf(i);
    Directions d = standing(b);
    if (b.attached >= 0.0) attach(b, d);
    vec4 shares = grassShares[b.kind];
    int joint = int(about.x), pieces = int(grassKinds[b.kind].x);
    vec4 laid = b.length * shares * vec4(lessThan(vec4(0, 1, 2, 3), vec4(about.x)));
    // The flat side's axes are level where a blade stands upright and go with it without a twist.
    float c = b.facing.x, s = b.facing.y;
    vec4 by = 1.0 / max(1.0 + d.z, 1e-3), outT = c * d.x + s * d.y, acrossT = c * d.y - s * d.x;
    vec4 outX = c - outT * by * d.x, outY = s - outT * by * d.y;
    vec4 acrossX = -s - acrossT * by * d.x, acrossY = c - acrossT * by * d.y;
    int low = max(joint - 1, 0), high = min(joint, pieces - 1);
    vec3 outwards = 0.5 * vec3(outX[low] + outX[high], outY[low] + outY[high], -outT[low] - outT[high]);
    vec3 across = 0.5 * vec3(acrossX[low] + acrossX[high], acrossY[low] + acrossY[high], -acrossT[low] - acrossT[high]);
    place = endOf(b.foot, laid, d) + b.width * (about.y * across + about.z * outwards);
    normalThere = normalize(facing.x * across + facing.y * outwards);
  }
`;

const kindOfBlade = (word: number): number => (word >>> 10) & 7;

function uniformsOf(header: Header, data: ArrayBuffer, first: number): Uniforms {
  const {blades, responses, bends, field, kinds} = header;
  const padded = <T>(values: T[], count: number, other: T): T[] =>
    [...values, ...new Array<T>(count - values.length).fill(other)];
  const angles = numbersOf(Int16Array, data, first, responses, 2 * field.samples * field.columns);
  const directions = Float32Array.from(numbersOf(Int16Array, data, first, bends, 12), (n) => n / 32767);
  return {
    grassBlades: {value: texture(wordsOfThings(numbersOf(Uint32Array, data, first, blades, 4), blades.count), 4)},
    grassResponses: {value: texture(Float32Array.from(angles), 2)},
    grassBends: {value: texture(directions, 4)},
    grassLow: {value: new Vector3(...blades.low_m)},
    grassStep: {value: new Vector3(...blades.step_m)},
    grassSizeSteps: {value: new Vector2(blades.length_step_m, blades.width_step_m)},
    grassField: {value: travelling(field, header.facts.period_s)},
    grassNow: {value: 0},
    grassLoad: {value: 1},
    grassBladeHeight: {value: header.height_m},
    grassShares: {value: padded(kinds.map(({shares}) => new Vector4(...padded(shares, 4, 0))), mostKinds, new Vector4())},
    grassKinds: {
      value: padded(kinds.map(({shares, bends: {first, in_plane, across}}) =>
        new Vector4(shares.length, first, in_plane, across)), mostKinds, new Vector4()),
    },
    grassMakes: {
      value: padded(kinds.flatMap(({makes}) => makes.map(({response, lean_rad, per_length, step_rad}) =>
        new Vector4(response, lean_rad, per_length, step_rad))), mostKinds * makesPerKind, new Vector4()),
    },
  };
}

// ---- How it looks

// Blades differ, let light through, and are darker where others stand around them.
function bladeMaterial(kind: Kind, uniforms: Uniforms): MeshStandardMaterial {
  const material = new MeshStandardMaterial({
    name: kind.name, roughness: 0.6, side: kind.two_sided ? DoubleSide : FrontSide,
    color: new Color().setRGB(...kind.color_srgb, SRGBColorSpace),
  });
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
        .replace('void main() {', `${poseShader}
          attribute float thing;
          varying vec3 grassTint;
          float bladeHash(float n) { return fract(sin(n) * 43758.5453); }
          void main() {`)
        .replace('#include <beginnormal_vertex>', `
          vec3 bladePlace, objectNormal;
          poseBlade(int(thing), position, normal.xy, bladePlace, objectNormal);
          float bright = bladeHash(0.731 * thing), yellow = bladeHash(1.317 * thing + 5.0) - 0.5;
          float above = (bladePlace.z - grassLow.z) / grassBladeHeight;
          grassTint = mix(0.45, 1.25, smoothstep(0.0, 0.9, above)) * (0.8 + 0.4 * bright) *
              vec3(1.0 + 0.45 * yellow, 1.0, 1.0 - 0.3 * yellow);`)
        .replace('#include <begin_vertex>', 'vec3 transformed = bladePlace;');
    shader.fragmentShader = shader.fragmentShader
        .replace('void main() {', 'varying vec3 grassTint;\nvoid main() {')
        .replace('#include <color_fragment>', 'diffuseColor.rgb *= grassTint;')
        .replace('#include <opaque_fragment>', lightThrough('vec3(0.40, 0.46, 0.12)'));
  };
  return material;
}

function geometryOf(kind: Kind, blades: Float32Array): InstancedBufferGeometry {
  const {vertices, triangles} = kind.skin, geometry = new InstancedBufferGeometry();
  const columns = (...which: number[]): BufferAttribute =>
    new BufferAttribute(Float32Array.from(vertices.flatMap((vertex) => which.map((i) => i < 0 ? 0 : vertex[i]))), which.length);
  geometry.setAttribute('position', columns(0, 1, 2));
  geometry.setAttribute('normal', columns(3, 4, -1));
  geometry.setAttribute('uv', columns(5, 6));
  geometry.setAttribute('thing', new InstancedBufferAttribute(blades, 1));
  geometry.setIndex(triangles);
  geometry.instanceCount = blades.length;
  return geometry;
}

// What is seen of the ground between blades.
function makeSoil(header: Header, low: Vector3, high: Vector3): Mesh {
  const color = new Color().setRGB(...header.kinds[0].color_srgb, SRGBColorSpace).multiplyScalar(0.4);
  const soil = new Mesh(new PlaneGeometry(high.x - low.x, high.y - low.y), new MeshStandardMaterial({color, roughness: 1}));
  soil.position.set((low.x + high.x) / 2, (low.y + high.y) / 2, low.z + 1e-3);
  soil.receiveShadow = true;
  return soil;
}

export function readGrass(data: ArrayBuffer): Loop {
  const {header, first} = readBlock<Header>(data);
  const {kinds, facts, blades} = header, {count, low_m, step_m} = blades;
  const last = numbersOf(Uint32Array, data, first, blades, 4).subarray(3 * count);
  const byKind = kinds.map((_, k) => Float32Array.from([...last.keys()].filter((i) => kindOfBlade(last[i]) === k)));
  const uniforms = uniformsOf(header, data, first);

  const root = new Group();
  root.rotation.x = -Math.PI / 2;  // from z up to y up
  const meshes: PlantMesh[] = [];
  const shadow = shadowMaterial(uniforms, `${poseShader}\nattribute float thing;`, `
    vec3 transformed, bladeNormal;
    poseBlade(int(thing), position, normal.xy, transformed, bladeNormal);`);
  kinds.forEach((kind, k) => {
    if (byKind[k].length === 0) return;
    const mesh = new Mesh(geometryOf(kind, byKind[k]), bladeMaterial(kind, uniforms));
    mesh.customDepthMaterial = shadow;
    meshes.push(mesh);
    root.add(mesh);
  });
  const low = new Vector3(...low_m), high = new Vector3(...low_m).addScaledVector(new Vector3(...step_m), 65535);
  root.add(makeSoil(header, low, high));
  root.updateMatrixWorld(true);
  const tallest = Math.max(header.height_m, 65535 * header.blades.length_step_m);
  const extent = new Box3(new Vector3(low.x, low.z, -high.y), new Vector3(high.x, high.z + tallest, -low.y));
  return {
    name: header.name, facts, root, meshes, movement: new InFieldWind(facts, header.field.samples, (now, wind) => {
      uniforms.grassNow.value = now;
      uniforms.grassLoad.value = wind * wind;
    }),
    vertices: new PosedVertices(kinds.map(({skin: {vertices}}, k) => ({
      vertices: vertices.map((vertex) => [...vertex.slice(0, 5), 0]), along: vertices.map((vertex) => vertex[6]),
      things: byKind[k], width: 1,
    })), uniforms, poseShader, `
      vec3 unused;
      poseBlade(int(thing), position, normal.xy, place, unused);`),
    field: {extent, textureRows: mostRows(uniforms), castsShadow: count <= mostWithShadows, weather: 'fair', view: 'over', told: `${grouped(count)} blades`},
  };
}
