// Sky, ground, light and camera around a plant.
import {
  BackSide, Box3, BufferAttribute, Color, DirectionalLight, HemisphereLight, MathUtils, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, PCFShadowMap, PerspectiveCamera, RingGeometry, Scene, ShaderMaterial, Shape, ShapeGeometry,
  SkinnedMesh, Sphere, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import type {Field, Loop} from './loop';

interface Weather { zenith: Color; horizon: Color; floor: Color; turf: Color; sun: number; sky: number }

// Flakes and streaks are seen before what is darker than they are.
const weathers: Record<Field['weather'], Weather> = {
  fair: {
    zenith: new Color(0x7fa9cf), horizon: new Color(0xe8eef0), floor: new Color(0xcdd2c4), turf: new Color(0x84906c),
    sun: 2.7, sky: 1.9,
  },
  rain: {
    zenith: new Color(0x4d565e), horizon: new Color(0x7d878e), floor: new Color(0x5d625a), turf: new Color(0x5a6250),
    sun: 0.5, sky: 2.6,
  },
  snow: {
    zenith: new Color(0x56616d), horizon: new Color(0x8a95a0), floor: new Color(0xa9b1b8), turf: new Color(0xc3cad1),
    sun: 0.6, sky: 2.8,
  },
};

export class Stage {
  readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(30);
  private readonly controls: OrbitControls;
  private readonly extent = new Box3();  // of the plant at rest, and of a sheet as it moves
  private readonly azimuth: number;
  private readonly view: Field['view'];
  private readonly weather: Weather;
  private framed = true;                 // until somebody moves the camera

  constructor(private readonly canvas: HTMLCanvasElement, loop: Loop) {
    this.view = loop.field?.view ?? 'beside';
    const weather = loop.field?.weather ?? 'fair';
    this.weather = weathers[weather];
    document.body.dataset.weather = weather;
    const moved = isSheet(loop) ? placesOf(loop) : [];
    this.azimuth = azimuthOf(moved, MathUtils.degToRad(loop.facts.heading_deg));
    this.renderer = new WebGLRenderer({canvas, antialias: true});
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;

    for (const mesh of loop.meshes) {
      mesh.castShadow = loop.field?.castsShadow ?? true;
      mesh.receiveShadow = true;
      mesh.frustumCulled = false;
      if (!loop.field) this.extent.union(restOf(mesh).applyMatrix4(mesh.matrixWorld));
    }
    if (loop.field) this.extent.copy(loop.field.extent);
    for (const places of moved) this.extent.union(new Box3().setFromPoints(places));
    this.scene.add(loop.root);
    this.addSurroundings(loop);
    this.checkLimits(loop);

    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.maxPolarAngle = MathUtils.degToRad(95);
    this.controls.addEventListener('start', () => { this.framed = false; });
    this.resize();
  }

  // Lets the camera glide on; true if it moved.
  moveCamera(): boolean { return this.controls.update(); }

  render(): void { this.renderer.render(this.scene, this.camera); }

  // To be called when the canvas may have another size.
  resize(): void {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    if (this.framed) this.frame();
    this.camera.updateProjectionMatrix();
  }

  // Puts the whole plant into the picture, with some air above and room for the controls below.
  private frame(): void {
    const size = this.extent.getSize(new Vector3()), center = this.extent.getCenter(new Vector3());
    const radius = Math.max(size.x, size.z) / 2, half = Math.tan(MathUtils.degToRad(this.camera.fov / 2));
    // A meadow is looked over, from beside it, and need not be in the picture to its corners.
    const share = this.view === 'over' ? 0.8 : 1.12;
    const polar = MathUtils.degToRad({beside: 85, over: 74, through: 88}[this.view]);
    // What drifts is looked through, from its edge: what is near is large and fast, as in weather.
    const distance = this.view === 'through' ?
        Math.max(size.y / 2 / half, radius) :
        radius + Math.max(1.12 * size.y / 2 / half, share * radius / half / this.camera.aspect);
    const direction = new Vector3(Math.sin(polar) * Math.cos(this.azimuth), Math.cos(polar),
                                  -Math.sin(polar) * Math.sin(this.azimuth));
    this.controls.target.copy(center).addScaledVector(new Vector3(0, -1, 0), 0.06 * size.y);
    this.camera.position.copy(this.controls.target).addScaledVector(direction, distance);
    this.camera.near = 0.01 * distance;
    this.camera.far = 60 * distance;
    this.controls.minDistance = 0.03 * distance;
    this.controls.maxDistance = 5 * distance;
    this.controls.update();
  }

  // Every morph target takes a uniform of the vertex shader and a layer of a texture.
  private checkLimits(loop: Loop): void {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const most = Math.min(gl.getParameter(gl.MAX_VERTEX_UNIFORM_VECTORS) - 64,
                          gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS));
    if ((loop.field?.textureRows ?? 0) > gl.getParameter(gl.MAX_TEXTURE_SIZE))
      throw new Error('it is larger than a texture of the graphics here can be');
    const targets = Math.max(...loop.meshes.map((mesh) => mesh.morphTargetInfluences?.length ?? 0));
    if (targets > most) throw new Error(`it has ${targets} morph targets, and the graphics here can blend ${most}`);
  }

  private addSurroundings(loop: Loop): void {
    const {center, radius} = this.extent.getBoundingSphere(new Sphere());
    const ground = new Vector3(center.x, this.extent.min.y, center.z);

    // From behind the camera's left shoulder, so that the shadow falls beside the plant.
    const towardsSun = new Vector3(-0.75, 1.1, 0.6).normalize().applyAxisAngle(
        new Vector3(0, 1, 0), this.azimuth + Math.PI / 2);
    const sun = new DirectionalLight(0xfff3e0, this.weather.sun);
    sun.position.copy(center).addScaledVector(towardsSun, 4 * radius);
    sun.target.position.copy(center);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    const reach = 1.25 * radius;  // room to sway
    Object.assign(sun.shadow.camera, {left: -reach, right: reach, bottom: -reach, top: reach,
                                      near: radius, far: 12 * radius});
    sun.shadow.normalBias = 2 * reach / 2048;
    sun.shadow.radius = 2.5;
    this.scene.add(sun, sun.target, new HemisphereLight(0xe4eef8, 0xa09c84, this.weather.sky));

    this.scene.add(makeSky(ground, 40 * radius, this.weather), makeTurf(ground, 2.2 * radius, this.weather));
    if (loop.facts.wind_speed_m_s > 0) this.scene.add(makeArrow(ground, radius, loop.facts.heading_deg, loop.field ? 0.65 : 0));
  }
}

// Of a mesh as it was loaded, in its own frame.
function restOf(mesh: Mesh): Box3 {
  if (mesh instanceof SkinnedMesh) {
    mesh.computeBoundingBox();
    return mesh.boundingBox!.clone();
  }
  return new Box3().setFromBufferAttribute(mesh.geometry.attributes.position as BufferAttribute);
}

// A single sheet of few vertices; what its edge hides may be all of it.
function isSheet(loop: Loop): boolean {
  return loop.meshes.length === 1 && loop.meshes[0].material.name === 'cloth';
}

// Where the corners of its triangles are at eight instants of the loop, three after three.
function placesOf(loop: Loop): Vector3[][] {
  const mesh = loop.meshes[0], index = mesh.geometry.index!, shapes = loop.movement.shapes.length;
  return Array.from({length: 8}, (_, i) => {
    loop.movement.show({playing: false, time: i * loop.facts.period_s / 8, speed: 1, wind: 1,
                        enabled: new Array<boolean>(shapes).fill(true)});
    return Array.from({length: index.count}, (_, corner) =>
      mesh.getVertexPosition(index.getX(corner), new Vector3()).applyMatrix4(mesh.matrixWorld));
  });
}

// Across the wind, where its work shows most; but where a sheet shows less than half as much there as from
// elsewhere, from there.
function azimuthOf(moved: Vector3[][], heading: number): number {
  const shown = (azimuth: number): number => {
    const towards = new Vector3(Math.cos(azimuth), 0, -Math.sin(azimuth)), normal = new Vector3();
    let area = 0;
    for (const places of moved) {
      for (let i = 0; i < places.length; i += 3) {
        normal.subVectors(places[i + 1], places[i]).cross(new Vector3().subVectors(places[i + 2], places[i]));
        area += Math.abs(normal.dot(towards));
      }
    }
    return area;
  };
  const across = heading - MathUtils.degToRad(75), upwind = heading - MathUtils.degToRad(145);
  return shown(across) < 0.5 * shown(upwind) ? upwind : across;
}

// A dome without seam: the floor goes over into the sky at the horizon.
function makeSky(center: Vector3, radius: number, {zenith, horizon, floor}: Weather): Mesh {
  const material = new ShaderMaterial({
    side: BackSide,
    depthWrite: false,
    uniforms: {zenith: {value: zenith}, horizon: {value: horizon}, ground: {value: floor}},
    vertexShader: /* glsl */ `
      varying vec3 direction;
      void main() {
        direction = position;
        gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
      }`,
    fragmentShader: /* glsl */ `
      #include <common>
      varying vec3 direction;
      uniform vec3 zenith, horizon, ground;
      void main() {
        float up = normalize(direction).y;
        vec3 color = up > 0.0 ? mix(horizon, zenith, pow(up, 0.75)) : mix(horizon, ground, smoothstep(0.0, 0.22, -up));
        // Noise below the step of eight bits hides the bands of a slow gradient.
        gl_FragColor = vec4(color + (rand(gl_FragCoord.xy) - 0.5) / 255.0, 1.0);
        #include <colorspace_fragment>
      }`,
  });
  const sky = new Mesh(new SphereGeometry(radius, 48, 32), material);
  sky.position.copy(center);
  sky.frustumCulled = false;
  sky.renderOrder = -1;
  return sky;
}

// A patch of ground that catches the shadow and fades out.
function makeTurf(center: Vector3, radius: number, {turf}: Weather): Mesh {
  const geometry = new RingGeometry(radius * 1e-3, radius, 96, 24);
  const position = geometry.attributes.position;
  const colors = new Float32Array(4 * position.count);
  for (let i = 0; i < position.count; ++i) {
    const distance = Math.hypot(position.getX(i), position.getY(i)) / radius;
    colors.set([turf.r, turf.g, turf.b, 1 - MathUtils.smoothstep(distance, 0.1, 1)], 4 * i);
  }
  geometry.setAttribute('color', new BufferAttribute(colors, 4));
  const material = new MeshStandardMaterial({vertexColors: true, transparent: true, depthWrite: false, roughness: 1});
  const mesh = new Mesh(geometry, material);
  mesh.rotation.x = -Math.PI / 2;
  mesh.position.copy(center);
  mesh.receiveShadow = true;
  return mesh;
}

// On the ground, upwind: where the wind blows to. Of a meadow, so much farther out, in radii.
function makeArrow(center: Vector3, radius: number, heading: number, farther: number): Mesh {
  const outline = [[-0.9, 0.02], [-0.62, 0.02], [-0.62, 0.06], [-0.5, 0]];
  const mirrored = outline.map(([x, y]) => [x, -y]).reverse();
  const shape = new Shape([...outline, ...mirrored].map(([x, y]) => new Vector2(radius * (x - farther), radius * y)));
  const material = new MeshBasicMaterial({color: 0xffffff, transparent: true, opacity: 0.55, depthWrite: false});
  const mesh = new Mesh(new ShapeGeometry(shape), material);
  mesh.rotation.set(-Math.PI / 2, 0, MathUtils.degToRad(heading));
  mesh.position.copy(center);
  mesh.renderOrder = 1;
  return mesh;
}
