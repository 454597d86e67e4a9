// What the page holds that is no glTF (src/tremula/io/page_block.hpp): JSON and numbers, textures of these, and where
// the graphics card puts the vertices that it makes of them.
import {
  BufferAttribute, BufferGeometry, Camera, DataTexture, DoubleSide, FloatType, MeshDepthMaterial, NoBlending, Points,
  RGBADepthPacking, RGBAFormat, RGBAIntegerFormat,
  RGFormat, Scene, ShaderMaterial, ShortType, UnsignedIntType, Vector2, WebGLRenderTarget, type IUniform,
  type WebGLRenderer,
} from 'three';
import type {VertexTable} from './loop';

export type Uniforms = Record<string, IUniform>;

export const textureWidth = 2048;  // what every card has

// Of a number's place in a texture.
export const texelShader = /* glsl */ `
  ivec2 texelOf(int i) { return ivec2(i & ${textureWidth - 1}, i >> ${Math.log2(textureWidth)}); }
`;

// What travels along the wind, from a table of samples times columns (src/tremula/wind/travelling_field.hpp).
export const travellingShader = /* glsl */ `
  struct Travelling {
    vec2 heading;
    float samples, columns, samplesPerMetre, samplesPerSecond, firstColumn, columnsPerMetre;
  };

  // At a place, so many samples into the loop; the table begins at texel \`first\`.
  vec4 travellingAt(sampler2D table, int first, Travelling f, vec2 place, float now) {
    float along = dot(f.heading, place), across = f.heading.x * place.y - f.heading.y * place.x;
    float at = now - f.samplesPerMetre * along;
    at -= f.samples * floor(at / f.samples);
    float column = clamp((across - f.firstColumn) * f.columnsPerMetre, 0.0, f.columns - 1.0);
    int samples = int(f.samples), columns = int(f.columns);
    int p = min(int(at), samples - 1), c = min(int(column), max(columns - 2, 0));
    int next = p + 1 == samples ? 0 : p + 1, right = c + 1 < columns ? 1 : 0;
    float t = at - float(p), w = column - float(c);
    int before = first + p * columns + c, after = first + next * columns + c;
    vec4 low = mix(texelFetch(table, texelOf(before), 0), texelFetch(table, texelOf(before + right), 0), w);
    vec4 high = mix(texelFetch(table, texelOf(after), 0), texelFetch(table, texelOf(after + right), 0), w);
    return mix(low, high, t);
  }

  // From axes along the wind and across to x and y.
  vec2 fromWind(Travelling f, vec2 v) {
    return vec2(f.heading.x * v.x - f.heading.y * v.y, f.heading.y * v.x + f.heading.x * v.y);
  }
`;

export interface FieldAxes {
  samples: number; columns: number; first_column_m: number; spacing_m: number; heading_deg: number; gust_speed_m_s: number;
}

// For the uniform of that type.
export function travelling(axes: FieldAxes, period: number): Record<string, number | Vector2> {
  const heading = axes.heading_deg * Math.PI / 180, perSecond = period > 0 ? axes.samples / period : 0;
  return {
    heading: new Vector2(Math.cos(heading), Math.sin(heading)),
    samples: axes.samples,
    columns: axes.columns,
    samplesPerMetre: axes.gust_speed_m_s > 0 ? perSecond / axes.gust_speed_m_s : 0,
    samplesPerSecond: perSecond,
    firstColumn: axes.first_column_m,
    columnsPerMetre: 1 / axes.spacing_m,
  };
}

// What moves in the shader of its vertices throws its shadow there: `begin` sets `transformed`. `declared` and `cut`, of
// pixels: what may be discarded.
export function shadowMaterial(uniforms: Uniforms, shader: string, begin: string, declared = '', cut = ''): MeshDepthMaterial {
  const material = new MeshDepthMaterial({depthPacking: RGBADepthPacking, side: DoubleSide});
  material.onBeforeCompile = (compiled) => {
    Object.assign(compiled.uniforms, uniforms);
    compiled.vertexShader = compiled.vertexShader
        .replace('void main() {', `${shader}\nvoid main() {`)
        .replace('#include <begin_vertex>', begin);
    compiled.fragmentShader = compiled.fragmentShader
        .replace('void main() {', `${declared}\nvoid main() {`)
        .replace('#include <map_fragment>', cut);
  };
  return material;
}

// Sunlight that comes through what is thin, in that colour; for the place of opaque_fragment.
export const lightThrough = (color: string): string => /* glsl */ `
  #if NUM_DIR_LIGHTS > 0
    float through = max(dot(-normal, directionalLights[0].direction), 0.0);
    outgoingLight += diffuseColor.rgb * ${color} * directionalLights[0].color * through;
  #endif
  #include <opaque_fragment>`;

// For constants in a shader.
export const glslFloat = (x: number): string => Number.isInteger(x) ? `${x}.0` : `${x}`;

// 12 345 as people write it.
export const grouped = (count: number): string => count.toLocaleString('en').replaceAll(',', ' ');

export const hasLetters = (data: ArrayBuffer, letters: string): boolean =>
  data.byteLength > 8 && new TextDecoder().decode(new Uint8Array(data, 0, 4)) === letters;

// The JSON, and where its numbers begin.
export function readBlock<Header>(data: ArrayBuffer): {header: Header; first: number} {
  const length = new DataView(data).getUint32(4, true);
  return {header: JSON.parse(new TextDecoder().decode(new Uint8Array(data, 8, length))) as Header, first: 8 + length};
}

// Where numbers are in the block: how many groups of them, and their first byte.
export interface Part { count: number; first_byte: number }

interface NumberArray<T> { new (bytes: ArrayBuffer): T; readonly BYTES_PER_ELEMENT: number }

// `width` numbers in a group; `first`: where the numbers of the block begin.
export function numbersOf<T>(type: NumberArray<T>, data: ArrayBuffer, first: number, {count, first_byte}: Part, width = 1): T {
  const begin = first + first_byte;
  return new type(data.slice(begin, begin + type.BYTES_PER_ELEMENT * width * count));
}

export function texture(values: Float32Array | Uint32Array | Int16Array, channels: 2 | 4): DataTexture {
  const texels = values.length / channels, rows = Math.max(1, Math.ceil(texels / textureWidth));
  const padded = new (values.constructor as new (length: number) => typeof values)(channels * textureWidth * rows);
  padded.set(values);
  const [format, type, internal] =
      values instanceof Uint32Array ? [RGBAIntegerFormat, UnsignedIntType, 'RGBA32UI'] as const :
      values instanceof Int16Array ? [RGBAIntegerFormat, ShortType, 'RGBA16I'] as const :
      [channels === 2 ? RGFormat : RGBAFormat, FloatType, null] as const;
  const result = new DataTexture(padded as BufferSource & typeof padded, textureWidth, rows, format, type);
  if (internal) result.internalFormat = internal;
  result.needsUpdate = true;
  return result;
}

// Rows of the largest of all textures.
export const mostRows = (uniforms: Uniforms): number => Math.max(...Object.values(uniforms).map(
    ({value}) => value instanceof DataTexture ? value.image.height : 0));

// From one word of all things after the other to the words of each.
export function wordsOfThings(words: Uint32Array, count: number): Uint32Array {
  const width = words.length / count, things = new Uint32Array(words.length);
  for (let word = 0; word < width; ++word) for (let i = 0; i < count; ++i) things[width * i + word] = words[word * count + i];
  return things;
}

// Alike ones: the six numbers of each of their vertices, position and normal as the shader reads them, and how far each
// is along; and what the shader knows each of them by.
export interface Alike { vertices: number[][]; along?: number[]; things: Float32Array; width: 1 | 2 }

// Where the graphics card puts vertices, asked one by one: for tests and scripts. Those of the first of the first alike
// ones come first, then those of its second.
export class PosedVertices implements VertexTable {
  readonly count: number;
  private readonly target = new WebGLRenderTarget(1, 1, {type: FloatType, format: RGBAFormat, depthBuffer: false});
  private readonly geometry = new BufferGeometry();
  private readonly scene = new Scene();

  // `shader` and what in it sets `place` from the attributes position, normal and thing.
  constructor(private readonly all: Alike[], uniforms: Uniforms, shader: string, pose: string) {
    this.count = all.reduce((sum, {vertices, things, width}) => sum + vertices.length * things.length / width, 0);
    const {width} = all[0];
    for (const [name, size] of [['position', 3], ['normal', 3], ['thing', width]] as const)
      this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(size), size));
    const point = new Points(this.geometry, new ShaderMaterial({
      uniforms, blending: NoBlending, depthTest: false,
      vertexShader: `${shader}
        attribute ${width === 1 ? 'float' : 'vec2'} thing;
        varying vec3 shown;
        void main() {
          vec3 place;
          ${pose}
          shown = place;
          gl_PointSize = 1.0;
          gl_Position = vec4(0, 0, 0, 1);
        }`,
      fragmentShader: 'varying vec3 shown; void main() { gl_FragColor = vec4(shown, 1.0); }',
    }));
    point.frustumCulled = false;
    this.scene.add(point);
  }

  position(index: number, renderer: WebGLRenderer): [number, number, number] {
    const {alike, number, vertex} = this.find(index), {position, normal, thing} = this.geometry.attributes;
    (position.array as Float32Array).set(alike.vertices[vertex].slice(0, 3));
    (normal.array as Float32Array).set(alike.vertices[vertex].slice(3, 6));
    (thing.array as Float32Array).set(alike.things.subarray(alike.width * number, alike.width * (number + 1)));
    for (const attribute of [position, normal, thing]) attribute.needsUpdate = true;
    renderer.setRenderTarget(this.target);
    renderer.render(this.scene, new Camera());
    renderer.setRenderTarget(null);
    const pixel = new Float32Array(4);
    renderer.readRenderTargetPixels(this.target, 0, 0, 1, 1, pixel);
    return [pixel[0], pixel[1], pixel[2]];
  }

  branch(index: number): number {
    const {alike, number} = this.find(index);
    return alike.things[alike.width * number];
  }

  along(index: number): number {
    const {alike, vertex} = this.find(index);
    return alike.along?.[vertex] ?? 0;
  }

  private find(index: number): {alike: Alike; number: number; vertex: number} {
    for (const alike of this.all) {
      const size = alike.vertices.length, count = size * alike.things.length / alike.width;
      if (index < count) return {alike, number: Math.floor(index / size), vertex: index % size};
      index -= count;
    }
    throw new RangeError('no such vertex');
  }
}
