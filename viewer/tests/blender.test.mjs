// The .glb as Blender plays it, against the poses: it clamps the weights of shape keys to 0 … 1.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {readFileSync} from 'node:fs';
import {describe, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {animate, distance, largestError, plants, readPoses, restNodes, settings} from './support.mjs';

const script = fileURLToPath(new URL('blender_vertices.py', import.meta.url));
const missing = spawnSync('blender', ['--version']).error;

describe('Blender', missing ? {skip: 'no Blender found'} : {}, () => {
  for (const plant of plants) {
    test(`plays ${plant.name} as the poses say`, () => {
      const paths = animate(plant, ['glb', 'csv']);
      const poses = readPoses(paths.csv), rest = restNodes(plant);
      const out = `${paths.glb}.json`, count = settings.period * settings.fps;
      const frames = [0, Math.floor(0.31 * count), Math.floor(0.77 * count), count];
      execFileSync('blender', ['--background', '--python-exit-code', '1', '--python', script, '--', paths.glb, out,
                               settings.fps, ...frames].map(String), {stdio: 'ignore'});
      const found = JSON.parse(readFileSync(out, 'utf8'));
      assert.deepEqual(found.keys.slice(0, 2), ['Basis', 'mean lean']);

      // The vertices that are on a node at rest: the tips of the axes.
      const size = Math.max(...rest.map((node) => distance(node, rest[0])));
      const pairs = found.rest.flatMap((vertex, index) => {
        const node = rest.findIndex((place) => distance(place, vertex) < 1e-6 * size);
        return node < 0 ? [] : [{index, node}];
      });
      assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
      for (const frame of frames) {
        const positions = pairs.map(({index}) => found.poses[frame][index]);
        assert.ok(largestError(pairs, positions, poses[frame % count], rest) < 0.01, `frame ${frame}`);
      }
    });
  }
});
