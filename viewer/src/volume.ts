// A volume of plants, by its shape model: ribbons along its strands, as often as a patch is laid side by side, each bent
// with its plant. The shader does what bent_point (src/tremula/deformation/bent_space.hpp) does; what the page holds is
// described in src/tremula/io/volume_page.hpp.
import {
  Box3, BufferAttribute, Color, DataTexture, DoubleSide, Group, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  MeshStandardMaterial, PlaneGeometry, RedFormat, Vector2, Vector3, type WebGLRenderer,
} from 'three';
import {
  glslFloat as float, grouped, lightThrough, mostRows, numbersOf, PosedVertices, readBlock, shadowMaterial, texelShader,
  texture, travelling, travellingShader, type FieldAxes, type Part, type Uniforms,
} from './block';
import type {Facts, Loop, PlantMesh} from './loop';
import {InFieldWind} from './movement';

interface Header {
  name: string;
  facts: Facts;
  low_m: [number, number];
  high_m: [number, number];
  ground_m: number;
  height_m: number;  // of what bends
  translucent: number;
  share: number;     // of all strands that there were
  shown: number;     // of them, in all squares
  patches: {first_strand: number; strands: number}[];
  squares: Part;
  points: Part;
  strands: Part;
  tallness: Part & {columns: number; rows: number; spacing_m: number};
  field: FieldAxes;
  sway: Part & {step_m: number; lean_m: [number, number]};
}

const mostWithShadows = 800_000;  // triangles, which are bent twice a frame

// Gauss and Legendre's four points between 0 and 1.
const quadrature = [0.3399810435848563, 0.8611363115940526].flatMap((x, i) => {
  const weight = [0.6521451548625461, 0.3478548451374538][i] / 2;
  return [[(1 - x) / 2, weight], [(1 + x) / 2, weight]];
});

// bentPlace gives a point of a patch in the wind: [m], z up. `plant`: its foot, and at which height its stem holds the
// point or below 0. What does not stand in the field is all in one point.
const poseShader = ({height_m: height}: Header): string => /* glsl */ `
  ${texelShader}
  ${travellingShader}
  uniform Travelling strandField;
  uniform highp sampler2D strandSway, strandTallness;
  uniform vec2 strandLow, strandHigh, strandLean;
  uniform vec3 strandMap;  // of tallness: its columns and rows, and how far they are apart
  uniform float strandNow, strandStep, strandLoad, strandGround;

  struct Stand { vec2 along; float tip, tall; };

  // Linear between places; the filter of a card has 8 bits.
  float tallnessAt(vec2 foot) {
    vec2 cell = clamp((foot - strandLow) / strandMap.z, vec2(0), strandMap.xy - 1.0);
    ivec2 low = min(ivec2(cell), ivec2(strandMap.xy) - 2);
    vec2 share = cell - vec2(low);
    vec2 near = vec2(texelFetch(strandTallness, low, 0).x, texelFetch(strandTallness, low + ivec2(1, 0), 0).x);
    vec2 far = vec2(texelFetch(strandTallness, low + ivec2(0, 1), 0).x, texelFetch(strandTallness, low + 1, 0).x);
    vec2 rows = mix(vec2(near.x, far.x), vec2(near.y, far.y), share.x);
    return mix(rows.x, rows.y, share.y);
  }

  Stand standOf(vec2 foot) {
    Stand s;
    bool within = all(greaterThanEqual(foot, strandLow)) && all(lessThanEqual(foot, strandHigh));
    s.tall = within ? tallnessAt(foot) : 0.0;
    vec2 gusts = strandStep * travellingAt(strandSway, 0, strandField, foot, strandNow).xy;
    vec2 top = strandLoad * (strandLean + fromWind(strandField, gusts));
    float far = length(top);
    s.along = far > 0.0 ? top / far : vec2(1, 0);
    s.tip = 1.35 * tanh(4.0 / 3.0 * far * ${float(1 / height)} / 1.35);
    return s;
  }

  float angleAt(float tip, float s) {
    float rest = 1.0 - s;
    return tip * (1.0 - rest * rest * rest);
  }

  vec3 turnedOver(Stand s, float sine, float cosine, vec3 v) {
    float ahead = dot(v.xy, s.along);
    return vec3(v.xy + ((cosine - 1.0) * ahead + sine * v.z) * s.along, cosine * v.z - sine * ahead);
  }

  // And the strand, which runs along \`tangent\` at rest.
  vec3 bentPlace(vec2 square, vec3 at, vec3 plant, inout vec3 tangent, out bool stands) {
    Stand stand = standOf(square + plant.xy);
    stands = stand.tall > 0.02;
    float s = clamp((plant.z >= 0.0 ? plant.z : at.z) * ${float(1 / height)}, 0.0, 1.0);
    vec2 bent = vec2(0);
    ${quadrature.map(([place, weight]) => `{
      float a = angleAt(stand.tip, s * ${float(place)});
      bent += ${float(weight)} * vec2(sin(a), cos(a));
    }`).join('\n')}
    bent *= s * ${float(height)};
    float angle = angleAt(stand.tip, s), sine = sin(angle), cosine = cos(angle);
    tangent = turnedOver(stand, sine, cosine, tangent);
    vec3 off = turnedOver(stand, sine, cosine, at - vec3(plant.xy, s * ${float(height)}));
    return vec3(square + plant.xy, strandGround) +
        (stands ? vec3(off.xy + stand.tall * bent.x * stand.along, stand.tall * (bent.y + off.z)) : vec3(0));
  }
`;

// ---- How it looks

const cornerShader = /* glsl */ `
  attribute vec2 thing;
  attribute vec4 tangent;  // and on which side of the strand, times half its width
  attribute vec3 plant;
  uniform float strandPixels;
  varying vec3 strandColor;
  float strandHash(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453); }

  vec3 ribbonCorner(vec3 at, vec3 eye, float perMetre, out vec3 facing) {
    bool stands;
    vec3 along = tangent.xyz, place = bentPlace(thing, at, plant, along, stands), sight = eye - place;
    vec3 across = cross(sight, along);
    across *= inversesqrt(max(dot(across, across), 1e-20));
    facing = normalize(cross(along, across));
    // What is thinner than a pixel flickers.
    float least = perMetre > 0.0 ? 0.4 * length(sight) / perMetre : 0.0;
    return stands ? place + sign(tangent.w) * max(abs(tangent.w), least) * across : place;
  }
`;

function strandMaterial(header: Header, pose: string, uniforms: Uniforms): MeshStandardMaterial {
  const material = new MeshStandardMaterial({name: 'strands', roughness: 0.6, side: DoubleSide, vertexColors: true});
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
        .replace('void main() {', `${pose}${cornerShader}\nvoid main() {`)
        .replace('#include <beginnormal_vertex>', `
          vec3 objectNormal, eye = vec3(cameraPosition.x, -cameraPosition.z, cameraPosition.y);
          vec3 strandPlace = ribbonCorner(position, eye, 0.5 * projectionMatrix[1][1] * strandPixels, objectNormal);
          float own = strandHash(thing + plant.xy), above = position.z * ${float(1 / header.height_m)};
          strandColor = mix(0.42, 1.15, smoothstep(0.0, 0.85, above)) * (0.82 + 0.36 * own) *
              vec3(1.0 + 0.2 * (strandHash(thing + plant.yx) - 0.5), 1.0, 1.0);`)
        .replace('#include <begin_vertex>', 'vec3 transformed = strandPlace;');
    shader.fragmentShader = shader.fragmentShader
        .replace('void main() {', 'varying vec3 strandColor;\nvoid main() {')
        .replace('#include <color_fragment>', '#include <color_fragment>\ndiffuseColor.rgb *= strandColor;')
        .replace('#include <opaque_fragment>', lightThrough(`${float(header.translucent)} * vec3(0.9, 1.0, 0.3)`));
  };
  return material;
}

// ---- What is read

interface Patch {
  vertices: number[][];  // position, foot and held: of the points
  geometry: InstancedBufferGeometry;
  triangles: number;
}

const colorOf = (word: number): [number, number, number] => [word >> 16 & 255, word >> 8 & 255, word & 255].map((c) => c / 255) as [number, number, number];

// Ribbons along the strands of a patch.
function patchOf(strands: Float32Array, points: Float32Array, squares: Float32Array): Patch {
  const count = strands.length / 8, vertices: number[][] = [], position: number[] = [], tangent: number[] = [];
  const plant: number[] = [], color: number[] = [], index: number[] = [];
  for (let i = 0; i < count; ++i) {
    const [first, length, x, y, held, root, tip] = strands.subarray(8 * i, 8 * i + 7);
    const low = colorOf(root), high = colorOf(tip), at = (k: number): Float32Array => points.subarray(4 * (first + k), 4 * (first + k) + 4);
    for (let k = 0; k < length; ++k) {
      const here = at(k), before = at(Math.max(k - 1, 0)), after = at(Math.min(k + 1, length - 1));
      const along = new Vector3(after[0] - before[0], after[1] - before[1], after[2] - before[2]).normalize();
      const share = k / (length - 1);
      vertices.push([here[0], here[1], here[2], x, y, held]);
      const corner = 2 * (vertices.length - 1);  // two of every point
      if (k > 0) index.push(corner - 2, corner - 1, corner, corner, corner - 1, corner + 1);
      for (const side of [-1, 1]) {
        position.push(here[0], here[1], here[2]);
        tangent.push(along.x, along.y, along.z, side * Math.max(here[3] / 2, 1e-7));
        plant.push(x, y, held);
        color.push(...low.map((c, n) => c + share * (high[n] - c)));
      }
    }
  }
  const geometry = new InstancedBufferGeometry();
  for (const [name, values, size] of [['position', position, 3], ['tangent', tangent, 4], ['plant', plant, 3], ['color', color, 3]] as const)
    geometry.setAttribute(name, new BufferAttribute(Float32Array.from(values), size));
  geometry.setAttribute('normal', geometry.getAttribute('position'));  // the shader makes its own
  geometry.setAttribute('thing', new InstancedBufferAttribute(squares, 2));
  geometry.setIndex(index);
  geometry.instanceCount = squares.length / 2;
  return {vertices, geometry, triangles: index.length / 3 * squares.length / 2};
}

function uniformsOf(header: Header, data: ArrayBuffer, first: number): Uniforms {
  const {tallness: {columns, rows, spacing_m}, sway} = header;
  const tallness = new DataTexture(numbersOf(Uint8Array, data, first, header.tallness), columns, rows, RedFormat);
  tallness.unpackAlignment = 1;
  tallness.needsUpdate = true;
  return {
    strandField: {value: travelling(header.field, header.facts.period_s)},
    strandSway: {value: texture(Float32Array.from(numbersOf(Int16Array, data, first, sway, 2)), 2)},
    strandTallness: {value: tallness},
    strandLow: {value: new Vector2(...header.low_m)},
    strandHigh: {value: new Vector2(...header.high_m)},
    strandLean: {value: new Vector2(...sway.lean_m)},
    strandMap: {value: new Vector3(columns, rows, spacing_m)},
    strandNow: {value: 0},
    strandStep: {value: sway.step_m},
    strandLoad: {value: 1},
    strandGround: {value: header.ground_m},
    strandPixels: {value: 1000},
  };
}

export function readVolume(data: ArrayBuffer): Loop {
  const {header, first} = readBlock<Header>(data);
  const {patches, squares, points, strands, low_m, high_m, ground_m, height_m, facts, share} = header;
  const uniforms = uniformsOf(header, data, first), pose = poseShader(header);
  const floats = (part: Part, width: number): Float32Array => numbersOf(Float32Array, data, first, part, width);
  const allPoints = floats(points, 4), allStrands = floats(strands, 8), allSquares = floats(squares, 4);

  const root = new Group();
  root.rotation.x = -Math.PI / 2;  // from z up to y up
  const meshes: PlantMesh[] = [], size = new Vector2();
  const shadow = shadowMaterial(uniforms, `${pose}${cornerShader}`, `
    vec3 facing, eye = vec3(cameraPosition.x, -cameraPosition.z, cameraPosition.y);
    vec3 transformed = ribbonCorner(position, eye, 0.0, facing);`);
  const material = strandMaterial(header, pose, uniforms);
  const made = patches.map(({first_strand, strands: count}, variant) => {
    const places = [...Array(squares.count).keys()].filter((i) => allSquares[4 * i + 2] === variant)
        .flatMap((i) => [allSquares[4 * i], allSquares[4 * i + 1]]);
    return patchOf(allStrands.subarray(8 * first_strand, 8 * (first_strand + count)), allPoints, Float32Array.from(places));
  });
  for (const {geometry} of made) {
    if (geometry.instanceCount === 0 || geometry.index!.count === 0) continue;
    const mesh = new Mesh(geometry, material);
    mesh.customDepthMaterial = shadow;
    mesh.onBeforeRender = (renderer: WebGLRenderer) => { uniforms.strandPixels.value = renderer.getDrawingBufferSize(size).y; };
    meshes.push(mesh);
    root.add(mesh);
  }
  const soil = new Mesh(new PlaneGeometry(high_m[0] - low_m[0], high_m[1] - low_m[1]),
                        new MeshStandardMaterial({color: new Color(...colorOf(allStrands[5])).multiplyScalar(0.35), roughness: 1}));
  soil.position.set((low_m[0] + high_m[0]) / 2, (low_m[1] + high_m[1]) / 2, ground_m + 1e-3 * height_m);
  soil.receiveShadow = true;
  root.add(soil);
  root.updateMatrixWorld(true);

  const triangles = made.reduce((sum, patch) => sum + patch.triangles, 0);
  return {
    name: header.name, facts, root, meshes, movement: new InFieldWind(facts, header.field.samples, (now, wind) => {
      uniforms.strandNow.value = now;
      uniforms.strandLoad.value = wind * wind;
    }, share < 1 ? `${(100 * share).toPrecision(2)} % of the strands, as much wider` : ''),
    vertices: new PosedVertices(made.map(({vertices, geometry}) => ({
      vertices, things: geometry.getAttribute('thing').array as Float32Array, width: 2,
    })), uniforms, pose, 'bool stands; vec3 along = vec3(0, 0, 1); place = bentPlace(thing, position, normal, along, stands);'),
    field: {
      extent: new Box3(new Vector3(low_m[0], ground_m, -high_m[1]), new Vector3(high_m[0], ground_m + height_m, -low_m[1])),
      textureRows: mostRows(uniforms), castsShadow: triangles <= mostWithShadows, weather: 'fair', view: 'over',
      told: `${grouped(header.shown)} strands`,
    },
  };
}
