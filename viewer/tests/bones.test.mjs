// A .glb on bones with several clips as three.js plays it, without a browser: against the poses of the program, and by the
// recipes of the guide.
import assert from 'node:assert/strict';
import {before, describe, test} from 'node:test';
import {AnimationClip, AnimationMixer, Group, Quaternion} from 'three';
import {clone} from 'three/addons/utils/SkeletonUtils.js';
import {bentCurve, carriedBy, poseOf, readBranches} from './bent_skin.mjs';
import {openSkin, readGltf, skinsIn, verticesOf} from './skin.mjs';
import {animateClips, distance, guide, heightOf, largestDistance, recipe, tolerance, withClips} from './support.mjs';

// More presets by name: TREMULA_PLANTS="bamboo oak birch willow" (minutes each).
const presets = ['sapling', ...(process.env.TREMULA_PLANTS ?? '').split(' ').filter(Boolean)];
const allowed = 0.005, framesPerSecond = 31, period = 20;

// The same numbers from 0 to 1 on every machine.
function* randomNumbers(seed) {
  for (let state = seed;;) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    yield state / 2 ** 32;
  }
}

function longestEdge(corners, rest, positions) {
  let longest = 0;
  corners.forEach((a, i) => {
    const b = corners[i % 3 === 2 ? i - 2 : i + 1], before = distance(rest[a], rest[b]);
    if (before > 1e-3) longest = Math.max(longest, distance(positions[a], positions[b]) / before);
  });
  return longest;
}

for (const preset of presets) {
  test(`every vertex of ${preset} is where the program has it, at ten random times of each clip`, async (t) => {
    const {glb, report} = animateClips({...withClips, name: `${preset}-winds`, input: preset});
    const skin = await openSkin(glb), branches = readBranches(preset), random = randomNumbers(11);
    const rest = poseOf(preset, 0, 0, framesPerSecond).nodes, height = heightOf(rest);
    assert.deepEqual(skin.animations.map(({name, duration}) => [name, duration]),
                     Object.keys(withClips.clips).map((name) => [name, period]));
    assert.equal(skin.joints, report.glb.joints);
    for (const [clip, speed] of Object.entries(withClips.clips)) {
      let off = 0, moved = 0, edge = 0;
      for (let i = 0; i < 10; ++i) {
        const frame = Math.floor(random.next().value * period * framesPerSecond);
        const pose = poseOf(preset, speed, frame, framesPerSecond);
        const curves = branches.map((branch) => bentCurve(branch, rest, pose));
        const found = skin.pose(clip, pose.time);
        found.forEach((at, v) => {
          off = Math.max(off, distance(at, carriedBy(curves[skin.branch[v]], skin.along[v], skin.rest[v])));
          moved = Math.max(moved, distance(at, skin.rest[v]));
        });
        edge = Math.max(edge, longestEdge(skin.corners, skin.rest, found));
      }
      t.diagnostic(`${clip}: off by ${(off / height).toExponential(2)} of the height, ` +
                   `moved by ${(moved / height).toFixed(3)}, edges longer by ${(edge - 1).toExponential(2)}`);
      assert.ok(off < (allowed + tolerance) * height, `${clip}: ${off} m of ${height} m`);
      assert.ok(off < 0.25 * moved, `${clip}: ${off} m off, where it moves by ${moved} m`);
      assert.ok(edge < 1.02, `${clip}: an edge is ${edge} times as long`);
    }
  });
}

// Runs a block of the guide on these, and returns what it has called so.
function run(block, names, result) {
  const statements = block.split('\n').filter((line) => !line.startsWith('import ')).join('\n');
  return new Function(...Object.keys(names), `${statements}\nreturn ${result};`)(...Object.values(names));
}

describe('the recipes for three.js', () => {
  let gltf, skin, height;
  before(async () => {
    const {glb} = animateClips(withClips);
    [gltf, skin] = [await readGltf(glb), await openSkin(glb)];
    height = heightOf(skin.rest);
  });

  test('plants of one skeleton play the loop from another instant each, exactly', () => {
    const scene = new Group();
    const mixers = run(recipe('js', 'clone(gltf.scene)'), {gltf, scene, AnimationMixer, clone}, 'mixers');
    const plants = scene.children;
    assert.equal(plants.length, 9);
    assert.equal(new Set(skinsIn(scene).map(({geometry}) => geometry)).size, skinsIn(plants[0]).length);
    assert.equal(new Set(plants.map((plant) => skinsIn(plant)[0].skeleton)).size, plants.length);
    const [{name}] = gltf.animations;
    const place = ({position: {x, y, z}}) => [x, -z, y];
    for (const seconds of [0, 3.7, 20]) {
      for (const mixer of mixers) mixer.update(seconds);
      const now = seconds === 0 ? 0 : seconds === 3.7 ? 3.7 : 23.7;
      plants.forEach((plant, i) => {
        const time = (now + period * i / plants.length) % period;
        const off = largestDistance(verticesOf(plant), skin.pose(name, time), place(plant));
        assert.ok(off < 1e-6 * height, `plant ${i} after ${now} s: ${off} m`);
      });
    }
  });

  test('a fade by the clock goes on where the gusts are', () => {
    const [line] = guide.match(/gale\.time = calm\.time[^`]*/);
    const mixer = new AnimationMixer(gltf.scene);
    const [calm, gale] = ['calm', 'gale'].map((name) => mixer.clipAction(AnimationClip.findByName(gltf.animations, name)));
    calm.play();
    mixer.update(3);
    run(line, {calm, gale}, 'undefined');
    const off = (clip, time) => largestDistance(verticesOf(gltf.scene), skin.pose(clip, time)) / height;
    mixer.update(0);
    assert.ok(off('calm', 3) < 1e-6);
    mixer.update(4.5);
    assert.ok(off('gale', 7.5) < 1e-6);
  });

  test('a wind between two clips is between them, and at its ends it is them', async (t) => {
    const mixer = new AnimationMixer(gltf.scene);
    const setWind = run(recipe('js', 'setEffectiveWeight'), {gltf, mixer, AnimationClip}, 'setWind');
    const turns = () => skinsIn(gltf.scene)[0].skeleton.bones.map(({quaternion}) => quaternion.clone());
    const at = (strength, time) => {
      setWind(strength);
      mixer.setTime(time);
      return turns();
    };
    const angle = (a, b) => {
      const {x, y, z} = new Quaternion().copy(a).invert().multiply(b);
      return 2 * Math.asin(Math.min(1, Math.hypot(x, y, z)));
    };
    let beyond = 0, far = 0, longest = 0;
    for (const time of [0, 2.345, 9.87, 16.1]) {
      const calm = at(0, time);
      assert.ok(largestDistance(verticesOf(gltf.scene), skin.pose('calm', time)) < 1e-6 * height);
      const gale = at(1, time);
      assert.ok(largestDistance(verticesOf(gltf.scene), skin.pose('gale', time)) < 1e-6 * height);
      for (const strength of [0.2, 0.5, 0.8]) {
        at(strength, time).forEach((turn, j) => {
          const whole = angle(calm[j], gale[j]);
          far = Math.max(far, whole);
          beyond = Math.max(beyond, angle(calm[j], turn) + angle(turn, gale[j]) - whole);
        });
        longest = Math.max(longest, longestEdge(skin.corners, skin.rest, verticesOf(gltf.scene)));
      }
    }
    t.diagnostic(`joints leave the way between their turns by ${beyond.toExponential(1)} rad of ${far.toFixed(2)}; ` +
                 `edges longer by ${(longest - 1).toExponential(2)}`);
    assert.ok(far > 0.05);
    assert.ok(beyond < 1e-6, `${beyond} rad`);
    assert.ok(longest < 1.02, `an edge is ${longest} times as long`);
  });
});
