// Impressionist trees: the quadrics of one, drawn as often as it stands there. Every level is shifted as the trunk is
// shifted there, and Gardner's texture says of every leaf whether it is there and how bright it is. The shader does what
// the library does (src/tremula/deformation/impression_motion.hpp, src/tremula/raytrace/impression_rays.cpp); what the
// page holds is described in src/tremula/io/impression_page.hpp.
import {
  Box3, BufferAttribute, Color, DoubleSide, Group, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  MeshStandardMaterial, SRGBColorSpace, Vector2, Vector3, Vector4,
} from 'three';
import {
  glslFloat as float, grouped, lightThrough, mostRows, numbersOf, PosedVertices, readBlock, shadowMaterial, texelShader,
  texture, travelling, travellingShader, type FieldAxes, type Part, type Uniforms,
} from './block';
import type {Facts, Loop} from './loop';
import {InFieldWind} from './movement';

type Triple = [number, number, number];

interface Header {
  name: string;
  facts: Facts;
  low_m: Triple;
  high_m: Triple;
  copies: Part;
  positions: Part;
  normals: Part;
  quadrics: Part;
  triangles: Part;
  paint: {centre_m: Triple; turn: number[]; offset_m: Triple; root: number[]; sign: Triple}[];
  bark_srgb: Triple;
  leaf_srgb: Triple;
  leaf_size_m: number;
  texture: {octaves: number; wavelength_m: number; stretch: number; falloff: number};
  cover: {middle_threshold: number; edge_threshold: number; softness: number; first_decile: number; ninth_decile: number};
  field: FieldAxes;
  sway: Part & {step_m: number};
  tremble: Part & {step_m: number};
  curve: {step_m: number; knots: number[][]; slopes: number[][]};
}

const mostWithShadows = 1_500_000;  // triangles, which are painted twice a frame
// Of a quadric in the texture of paint: centre and 1 for the trunk, offset, sign, rows of turn, rows of root.
const paintTexels = 9;

// paintedPlace gives a place of the resting tree in the wind: [m], z up.
const poseShader = ({curve: {knots}}: Header): string => /* glsl */ `
  ${texelShader}
  ${travellingShader}
  uniform Travelling paintedField;
  uniform highp sampler2D paintedCopies, paintedSway, paintedTremble, paintedPaint;
  uniform vec4 paintedKnots[${Math.max(knots.length, 1)}], paintedSlopes[${Math.max(knots.length, 1)}];
  uniform float paintedKnotStep, paintedNow, paintedWind;
  uniform vec2 paintedSteps;  // of the sway and of the trembling

  struct Painted { vec3 foot; float scale, now, shift; vec2 turn, top; };

  Painted paintedOf(float thing) {
    vec4 a = texelFetch(paintedCopies, texelOf(2 * int(thing)), 0), b = texelFetch(paintedCopies, texelOf(2 * int(thing) + 1), 0);
    Painted p;
    p.foot = a.xyz;
    p.scale = a.w;
    p.turn = b.xy;
    p.now = paintedNow + b.z * paintedField.samplesPerSecond;
    p.shift = b.w;
    p.top = paintedSteps.x * travellingAt(paintedSway, 0, paintedField, a.xy, p.now).xy;
    return p;
  }
  vec2 turnedOut(Painted p, vec2 v) { return vec2(p.turn.x * v.x - p.turn.y * v.y, p.turn.y * v.x + p.turn.x * v.y); }
  vec2 turnedIn(Painted p, vec2 v) { return vec2(p.turn.x * v.x + p.turn.y * v.y, p.turn.x * v.y - p.turn.y * v.x); }

  // Where the level at a height stands, along x and y of the world but in metres of the tree, and how that goes with
  // height.
  void shiftAt(Painted p, float height, out vec2 shift, out vec2 rise) {
    vec4 value = vec4(0), slope = vec4(0);
    ${knots.length > 0 ? /* glsl */ `
    float place = max(height / paintedKnotStep, 0.0), h = paintedKnotStep;
    int low = min(int(place), ${knots.length - 1});
    float t = place - float(low);
    if (low == ${knots.length - 1}) {
      slope = paintedSlopes[low];
      value = paintedKnots[low] + t * h * slope;
    } else {
      vec4 up = paintedKnots[low + 1] - paintedKnots[low], a = h * paintedSlopes[low], b = h * paintedSlopes[low + 1];
      value = paintedKnots[low] + t * (a + t * ((3.0 * up - 2.0 * a - b) + t * (a + b - 2.0 * up)));
      slope = (a + t * (2.0 * (3.0 * up - 2.0 * a - b) + 3.0 * t * (a + b - 2.0 * up))) / h;
    }` : ''}
    // Loads go with the square of the wind.
    float load = paintedWind * paintedWind;
    shift = load * fromWind(paintedField, value.xy + value.zw * p.top);
    rise = load * fromWind(paintedField, slope.xy + slope.zw * p.top);
  }

  vec3 paintedPlace(Painted p, vec3 resting, out vec2 rise) {
    vec2 shift;
    shiftAt(p, resting.z, shift, rise);
    return p.foot + p.scale * vec3(turnedOut(p, resting.xy) + shift, resting.z);
  }
`;

// ---- How it looks

// What goes from corners to pixels: where in the texture a place is, from the middle of its quadric as a sphere and
// where the eye looks there; whose leaves, and 1 on the trunk.
const paintVaryings = /* glsl */ `
  varying vec3 paintedAt, paintedSphere, paintedSight, paintedResting;
  flat varying float paintedTrunk;
  flat varying uint paintedQuadric;
  flat varying vec2 paintedOwn;
`;

const hashShader = /* glsl */ `
  uint paintHash(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
  }
  float paintUnit(uint x) { return float(paintHash(x) >> 8) * ${float(2 ** -24)}; }
`;

const cornerShader = /* glsl */ `
  attribute float thing;
  attribute float quadric;
  ${paintVaryings}
  ${hashShader}
  vec3 paintOf(int texel) { return texelFetch(paintedPaint, texelOf(${paintTexels} * int(quadric + 0.5) + texel), 0).xyz; }
  vec3 times(int row, vec3 v) { return vec3(dot(paintOf(row), v), dot(paintOf(row + 1), v), dot(paintOf(row + 2), v)); }

  vec3 paintCorner(vec3 resting, vec3 upright, out vec3 facing) {
    Painted p = paintedOf(thing);
    vec2 rise;
    vec3 place = paintedPlace(p, resting, rise);
    facing = vec3(turnedOut(p, upright.xy), upright.z);
    facing.z -= dot(rise, facing.xy);
    facing = normalize(facing);

    vec4 centre = texelFetch(paintedPaint, texelOf(${paintTexels} * int(quadric + 0.5)), 0);
    paintedTrunk = centre.w;
    paintedResting = resting - centre.xyz;
    // "The vibration is projected onto the tangent plane of the envelope" (F section 5.3).
    vec3 gusts = paintedWind * paintedSteps.y * travellingAt(paintedTremble, 0, paintedField, place.xy, p.now).xyz;
    vec3 moved = vec3(turnedIn(p, fromWind(paintedField, gusts.xy)), gusts.z);
    moved -= dot(moved, upright) * upright;
    paintedAt = paintOf(1) + p.shift + times(3, paintedResting - moved);
    paintedSphere = paintOf(2) * times(6, paintedResting);
    vec3 sight = place - vec3(cameraPosition.x, -cameraPosition.z, cameraPosition.y);
    paintedSight = times(6, vec3(turnedIn(p, sight.xy - rise * sight.z), sight.z));
    paintedQuadric = uint(quadric + 0.5);
    uint number = uint(thing + 0.5);
    paintedOwn = vec2(paintUnit(3u * number + 0x51ed27u), paintUnit(3u * number + 0x51ed28u));
    return place;
  }
`;

// Leaves are cells of space: the texture decides of each as a whole. Far away, where a leaf is less than a pixel, a cell
// is as large as one, so that nothing flickers.
const leafShader = ({texture: {octaves, wavelength_m: wavelength, stretch, falloff}, leaf_size_m, cover}: Header): string => /* glsl */ `
  ${paintVaryings}
  ${hashShader}
  struct Leaf { vec3 middle; uint number; float size; };

  Leaf leafAt(vec3 at) {
    float pixel = max(length(dFdx(at)), length(dFdy(at)));
    float size = ${float(leaf_size_m)} * exp2(max(0.0, ceil(log2(pixel * ${float(1 / leaf_size_m)}))));
    vec3 place = at / size, low = floor(place - 0.5);
    Leaf leaf = Leaf(at, 0u, size);
    float least = 1e9;
    for (int i = 0; i < 8; ++i) {
      vec3 corner = low + vec3(i & 1, (i >> 1) & 1, i >> 2);
      uvec3 whole = uvec3(ivec3(corner));
      uint number = paintHash((whole.x * 73856093u) ^ (whole.y * 19349663u) ^ (whole.z * 83492791u));
      vec3 strewn = vec3(number & 1023u, (number >> 10) & 1023u, (number >> 20) & 1023u) / 1023.0 - 0.5;
      vec3 middle = corner + 0.5 + 0.7 * strewn;
      float apart = dot(middle - place, middle - place);
      if (apart < least) { least = apart; leaf.middle = size * middle; leaf.number = number; }
    }
    return leaf;
  }

  // Gardner's (src/tremula/geometry/impression.hpp).
  float gardner(vec3 at) {
    const float halfTurn = 3.14159265;
    vec4 phase = 4.0 * halfTurn * fract(at.xyzz * vec4(1.0, ${float(stretch)}, 1.0, ${float(stretch)}) * ${float(1 / (2 * wavelength))});
    vec4 half_ = 0.5 * phase;
    float alongX = 0.0, alongY = 0.0, sum = 0.0, amplitude = 1.0, scale = 1.0;
    for (int i = 0; i < ${octaves}; ++i) {
      vec4 s = sin(scale * half_);
      alongX += amplitude * sin(scale * phase.x + halfTurn * (0.5 * s.y + s.z));
      alongY += amplitude * sin(scale * phase.y + halfTurn * (0.5 * s.x + s.w));
      sum += amplitude;
      amplitude *= ${float(falloff)};
      scale *= 2.0;
    }
    return (alongX + sum) * (alongY + sum) / (4.0 * sum * sum);
  }

  // How far within the outline of its quadric the eye sees a place: 1 amid it, 0 on it.
  float middleOf(vec3 sphere, vec3 sight) {
    float along = dot(sphere, sight), size = dot(sphere, sphere) * dot(sight, sight);
    return size > 0.0 ? min(along * along / size, 1.0) : 1.0;
  }

  bool isThere(Leaf leaf, float value, float middle, bool front) {
    float threshold = mix(${float(cover.edge_threshold)}, ${float(cover.middle_threshold)}, middle);
    float opacity = clamp(0.5 + (value - threshold) * ${float(1 / cover.softness)}, 0.0, 1.0);
    return paintUnit(leaf.number + 0x9e3779b9u * (2u * paintedQuadric + (front ? 0u : 1u))) < opacity;
  }

  vec3 leafTint(Leaf leaf, float value) {
    float bright = clamp((value - ${float(cover.first_decile)}) * ${float(1 / (cover.ninth_decile - cover.first_decile))}, 0.0, 1.3);
    float warm = paintedOwn.y - 0.5 + 0.4 * (paintUnit(leaf.number + 4u) - 0.5);
    return (0.85 + 0.3 * paintedOwn.x) * (0.8 + 0.4 * paintUnit(leaf.number + 3u)) * (0.6 + 0.5 * bright) *
        vec3(1.0 + 0.3 * warm, 1.0, 1.0 - 0.2 * warm);
  }

  vec3 turnOf(Leaf leaf) {
    float z = 2.0 * paintUnit(leaf.number + 1u) - 1.0, angle = 6.2831853 * paintUnit(leaf.number + 2u);
    return vec3(sqrt(1.0 - z * z) * vec2(cos(angle), sin(angle)), z);
  }

  float furrows(vec3 resting) {
    vec2 at = vec2(4.1 * atan(resting.y, resting.x), 1.7 * resting.z), low = floor(at), t = smoothstep(0.0, 1.0, at - low);
    ivec2 i = ivec2(low);
    vec4 v;
    for (int k = 0; k < 4; ++k) v[k] = paintUnit(uint(i.x + (k & 1)) * 0x9e3779b9u + paintHash(uint(i.y + (k >> 1)) + 7u));
    return 0.75 * mix(mix(v.x, v.y, t.x), mix(v.z, v.w, t.x), t.y) + 0.375;
  }
`;

function treeMaterial(header: Header, pose: string, uniforms: Uniforms): MeshStandardMaterial {
  const material = new MeshStandardMaterial({name: 'leaves', roughness: 0.8, side: DoubleSide});
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
        .replace('void main() {', `${pose}${cornerShader}\nvoid main() {`)
        .replace('#include <beginnormal_vertex>', 'vec3 objectNormal, paintedPlaceHere = paintCorner(position, normal, objectNormal);')
        .replace('#include <begin_vertex>', 'vec3 transformed = paintedPlaceHere;');
    shader.fragmentShader = shader.fragmentShader
        .replace('void main() {', `uniform vec3 paintedBark, paintedLeaf;\n${leafShader(header)}\nvoid main() {`)
        .replace('#include <color_fragment>', `
          Leaf leaf = leafAt(paintedAt);
          bool leafy = paintedTrunk < 0.5;
          if (leafy) {
            float value = gardner(leaf.middle);
            if (!isThere(leaf, value, middleOf(paintedSphere, paintedSight), gl_FrontFacing)) discard;
            // Other leaves are before the light of what is seen through holes.
            diffuseColor.rgb = min(leafTint(leaf, value) * paintedLeaf, 0.5) * (gl_FrontFacing ? 1.0 : 0.6);
          } else {
            diffuseColor.rgb = (0.5 + 0.6 * furrows(paintedResting)) * paintedBark;
          }`)
        .replace('#include <normal_fragment_begin>', `
          #include <normal_fragment_begin>
          float upwards = dot(normal, mat3(viewMatrix) * vec3(0, 1, 0)) * (gl_FrontFacing ? 1.0 : -1.0);
          vec3 turned = turnOf(leaf);
          // Leaves below have others between them and the sky.
          if (leafy) diffuseColor.rgb *= 1.05 + 0.45 * upwards;
          if (leafy) normal = normalize(normal + 0.9 * mat3(viewMatrix) * vec3(turned.x, turned.z, -turned.y));`)
        .replace('#include <opaque_fragment>', lightThrough('float(leafy) * vec3(0.40, 0.46, 0.12)'));
  };
  return material;
}

// ---- What is read

function uniformsOf(header: Header, data: ArrayBuffer, first: number): Uniforms {
  const {copies, sway, tremble, paint, curve, facts} = header;
  const gusts = (part: Part, width: 2 | 4): Float32Array => Float32Array.from(numbersOf(Int16Array, data, first, part, width));
  const rows = (matrix: number[]): number[] => [0, 3, 6].flatMap((i) => [...matrix.slice(i, i + 3), 0]);
  const words = paint.flatMap(({centre_m, offset_m, sign, turn, root}, i) => [
    ...centre_m, i === 0 ? 1 : 0, ...offset_m, 0, ...sign, 0, ...rows(turn), ...rows(root),
  ]);
  const vectors = (list: number[][]): Vector4[] => list.length > 0 ? list.map((v) => new Vector4(...v)) : [new Vector4()];
  const linear = (srgb: Triple): Color => new Color().setRGB(...srgb, SRGBColorSpace);
  return {
    paintedField: {value: travelling(header.field, facts.period_s)},
    paintedCopies: {value: texture(numbersOf(Float32Array, data, first, copies, 8), 4)},
    paintedSway: {value: texture(gusts(sway, 2), 2)},
    paintedTremble: {value: texture(gusts(tremble, 4), 4)},
    paintedPaint: {value: texture(Float32Array.from(words), 4)},
    paintedKnots: {value: vectors(curve.knots)},
    paintedSlopes: {value: vectors(curve.slopes)},
    paintedKnotStep: {value: curve.step_m},
    paintedSteps: {value: new Vector2(sway.step_m, tremble.step_m)},
    paintedNow: {value: 0},
    paintedWind: {value: 1},
    paintedBark: {value: linear(header.bark_srgb)},
    paintedLeaf: {value: linear(header.leaf_srgb)},
  };
}

export function readImpressions(data: ArrayBuffer): Loop {
  const {header, first} = readBlock<Header>(data);
  const {copies, positions, normals, quadrics, triangles, facts, low_m, high_m} = header;
  const uniforms = uniformsOf(header, data, first), pose = poseShader(header);
  const position = numbersOf(Float32Array, data, first, positions, 3), normal = numbersOf(Float32Array, data, first, normals, 3);
  const things = Float32Array.from({length: copies.count}, (_, i) => i);

  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(position, 3));
  geometry.setAttribute('normal', new BufferAttribute(normal, 3));
  geometry.setAttribute('quadric', new BufferAttribute(Float32Array.from(numbersOf(Uint32Array, data, first, quadrics)), 1));
  geometry.setAttribute('thing', new InstancedBufferAttribute(things, 1));
  geometry.setIndex(new BufferAttribute(numbersOf(Uint32Array, data, first, triangles, 3), 1));
  geometry.instanceCount = copies.count;
  const mesh = new Mesh(geometry, treeMaterial(header, pose, uniforms));
  mesh.customDepthMaterial = shadowMaterial(uniforms, `${pose}${cornerShader}`, `
    vec3 facing, transformed = paintCorner(position, vec3(0, 0, 1), facing);`, leafShader(header), `
    Leaf leaf = leafAt(paintedAt);
    if (paintedTrunk < 0.5 && !isThere(leaf, gardner(leaf.middle), 0.6, gl_FrontFacing)) discard;`);
  const root = new Group();
  root.rotation.x = -Math.PI / 2;  // from z up to y up
  root.add(mesh);
  root.updateMatrixWorld(true);

  const extent = new Box3(new Vector3(low_m[0], low_m[2], -high_m[1]), new Vector3(high_m[0], high_m[2], -low_m[1]));
  const size = extent.getSize(new Vector3()), wide = Math.max(size.x, size.z) > 2.5 * size.y;
  return {
    name: header.name, facts, root, meshes: [mesh], movement: new InFieldWind(facts, header.field.samples, (now, wind) => {
      uniforms.paintedNow.value = now;
      uniforms.paintedWind.value = wind;
    }),
    vertices: new PosedVertices([{
      vertices: Array.from({length: positions.count}, (_, i) => [...position.subarray(3 * i, 3 * i + 3), ...normal.subarray(3 * i, 3 * i + 3)]),
      things, width: 1,
    }], uniforms, pose, `
      vec2 rise;
      place = paintedPlace(paintedOf(thing), position, rise);`),
    field: {
      extent, textureRows: mostRows(uniforms), castsShadow: triangles.count * copies.count <= mostWithShadows,
      weather: 'fair', view: wide ? 'over' : 'beside', told: copies.count === 1 ? '1 painted tree' : `${grouped(copies.count)} painted trees`,
    },
  };
}
