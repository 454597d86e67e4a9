// The .glb as Blender plays it, against the poses: it clamps the weights of shape keys to 0 … 1.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {readFileSync, writeFileSync} from 'node:fs';
import {describe, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {openSkin} from './skin.mjs';
import {
  animate, animateClips, distance, heightOf, largestDistance, largestError, plants, readPoses, recipe, restNodes, settings,
  tolerance, withClips,
} from './support.mjs';

const script = fileURLToPath(new URL('blender_vertices.py', import.meta.url));
const missing = spawnSync('blender', ['--version']).error;

const forest = fileURLToPath(new URL('blender_forest.py', import.meta.url));
const run = (python, ...more) => execFileSync('blender', ['--background', '--python-exit-code', '1', '--python', python, '--',
                                                          ...more].map(String), {stdio: 'ignore'});

describe('Blender', missing ? {skip: 'no Blender found'} : {}, () => {
  for (const plant of plants) {
    for (const morphs of ['biased', 'paired']) {
      test(`plays ${plant.name} as the poses say, ${morphs}`, () => {
        const paths = animate(plant, ['glb', 'csv'], {morphs});
        const poses = readPoses(paths.csv), rest = restNodes(plant);
        const out = `${paths.glb}.json`, count = settings.period * settings.fps;
        const frames = [0, Math.floor(0.31 * count), Math.floor(0.77 * count), count];
        run(script, paths.glb, out, settings.fps, ...frames);
        const found = JSON.parse(readFileSync(out, 'utf8'));
        assert.deepEqual(found.keys.slice(0, 2), ['Basis', 'mean lean']);

        // The vertices that are on a node at rest: the tips of the axes.
        const near = 0.5 * tolerance * heightOf(rest);
        const pairs = found.rest.flatMap((vertex, index) => {
          const node = rest.findIndex((place) => distance(place, vertex) < near);
          return node < 0 ? [] : [{index, node}];
        });
        assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
        for (const frame of frames) {
          const positions = pairs.map(({index}) => found.poses[frame][index]);
          assert.ok(largestError(pairs, positions, poses[frame % count], rest) < tolerance, `frame ${frame}`);
        }
      });
    }
  }

  // Frames of Blender fall between keys of the file.
  const framesPerSecond = 24, frames = [0, 81, 237, 427, 480];
  async function comparePoses(glb, joints, t) {
    const out = `${glb}.json`;
    run(script, glb, out, framesPerSecond, ...frames);
    const found = JSON.parse(readFileSync(out, 'utf8')), skin = await openSkin(glb), height = heightOf(skin.rest);
    assert.deepEqual(found.bones, [joints]);
    assert.deepEqual(Object.keys(found.clips).sort(), skin.animations.map(({name}) => name).sort());
    let off = largestDistance(found.rest, skin.rest), moved = 0;
    for (const [clip, poses] of Object.entries(found.clips)) {
      for (const [frame, vertices] of Object.entries(poses)) {
        off = Math.max(off, largestDistance(vertices, skin.pose(clip, frame / framesPerSecond)));
        moved = Math.max(moved, largestDistance(vertices, skin.rest));
      }
    }
    t.diagnostic(`off by ${(off / height).toExponential(2)} of the height at most, moved by ${(moved / height).toFixed(3)}`);
    assert.ok(moved > 20 * tolerance * height);
    assert.ok(off < tolerance * height, `${off} m of ${height} m`);
  }

  for (const plant of plants) {
    test(`plays every vertex of ${plant.name} on bones as the file says`, async (t) => {
      const {glb} = animate({...plant, name: `${plant.name}-bones`}, ['glb'], {pose: 'bent', form: 'skin'});
      await comparePoses(glb, (await openSkin(glb)).joints, t);
    });
  }

  for (const compress of ['quantised', 'none']) {
    test(`plays every vertex of a plant in several winds as the file says, ${compress}`, async (t) => {
      const {glb, report} = animateClips(withClips, {compress});
      await comparePoses(glb, report.glb.joints, t);
    });
  }

  test('makes a forest by the recipe in the guide, on bones', () => {
    const {glb} = animate({...plants[0], name: 'sapling-bones'}, ['glb'], {pose: 'bent', form: 'skin'});
    writeFileSync(`${glb}.py`, recipe('python', 'find_armature'));
    run(forest, glb, `${glb}.py`);
  });

  test('makes a forest of another wind in the file, too', () => {
    const {glb} = animateClips(withClips);
    writeFileSync(`${glb}.py`, recipe('python', 'find_armature').replace('clip = "wind loop"', 'clip = "gale"'));
    run(forest, glb, `${glb}.py`, 'gale');
  });

  test('makes a forest by the recipe in the guide, of morph targets', () => {
    const {glb} = animate(plants[0], ['glb']);
    writeFileSync(`${glb}.py`, recipe('python', 'shape_keys'));
    run(forest, glb, `${glb}.py`);
  });
});
