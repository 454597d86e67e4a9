// The .glb as Blender plays it, against the poses: it clamps the weights of shape keys to 0 … 1.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {readFileSync, writeFileSync} from 'node:fs';
import {describe, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {
  animate, distance, heightOf, largestError, plants, readPoses, restNodes, settings, tolerance,
} from './support.mjs';

const script = fileURLToPath(new URL('blender_vertices.py', import.meta.url));
const missing = spawnSync('blender', ['--version']).error;

const forest = fileURLToPath(new URL('blender_forest.py', import.meta.url));
const guide = fileURLToPath(new URL('../../docs/guide/animate.md', import.meta.url));
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

  for (const plant of plants) {
    test(`plays ${plant.name} on bones as the program poses it`, () => {
      const allowed = 0.005;
      const paths = animate({...plant, name: `${plant.name}-bones`}, ['glb', 'csv'],
                            {pose: 'bent', form: 'skin', tolerance: allowed});
      const poses = readPoses(paths.csv), rest = restNodes(plant), height = heightOf(rest);
      const out = `${paths.glb}.json`, count = settings.period * settings.fps;
      const frames = [0, 0.17, 0.31, 0.5, 0.77].map((part) => Math.floor(part * count));
      run(script, paths.glb, out, settings.fps, ...frames);
      const found = JSON.parse(readFileSync(out, 'utf8'));
      assert.equal(found.bones.length, 1);
      assert.ok(found.bones[0] > 1);
      assert.equal(found.clips.length, 1);
      const pairs = found.rest.flatMap((vertex, index) => {
        const node = rest.findIndex((place) => distance(place, vertex) < 0.5 * tolerance * height);
        return node < 0 ? [] : [{index, node}];
      });
      assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
      for (const frame of frames) {
        for (const {index, node} of pairs) {
          const error = distance(found.poses[frame][index], poses[frame].nodes[node]);
          assert.ok(error < (allowed + tolerance) * height, `frame ${frame} node ${node}: ${error} m`);
        }
      }
    });
  }

  test('makes a forest by the recipe in the guide', () => {
    const {glb} = animate(plants[0], ['glb']);
    const recipe = readFileSync(guide, 'utf8').match(/```python\n(import bpy[^]*?)```/)[1];
    writeFileSync(`${glb}.py`, recipe);
    run(forest, glb, `${glb}.py`);
  });
});
