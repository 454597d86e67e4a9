// The .glb as any other application with three.js plays it, against the page and against the poses.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, before, describe, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';
import {build} from 'vite';
import {
  animate, distance, heightOf, largestError, launchBrowser, needsBrowser, openPage, plants, readPoses, restNodes, settings,
  tips, tolerance,
} from './support.mjs';

async function bundlePlayer() {
  const entry = fileURLToPath(new URL('player.js', import.meta.url));
  const [bundle] = await build({
    configFile: false, logLevel: 'warn',
    build: {write: false, lib: {entry, formats: ['iife'], name: 'player'}},
  });
  return bundle.output[0].code;
}

describe('the .glb', needsBrowser, () => {
  let browser, player;
  before(async () => {
    player = await bundlePlayer();
    browser = await launchBrowser();
  });
  after(() => browser?.close());

  const load = async (path) => {
    const {page, complaints} = await openPage(browser);
    await page.addScriptTag({content: player});
    const loaded = await page.evaluate((bytes) => window.load(bytes), readFileSync(path).toString('base64'));
    return {page, complaints, ...loaded};
  };

  for (const plant of plants) {
    test(`${plant.name} plays in three.js as in the page, in every form`, async () => {
      const paths = animate(plant, ['html', 'csv']);
      const poses = readPoses(paths.csv), rest = restNodes(plant), height = heightOf(rest);
      const own = await openPage(browser, {viewport: {width: 300, height: 200}});
      await own.page.goto(pathToFileURL(paths.html).href);
      await own.page.evaluate(() => window.tremula.ready);
      await own.page.evaluate(() => window.tremula.pause());
      await own.page.locator('#wind').fill('0');
      const vertices = await own.page.evaluate(() => Array.from({length: window.tremula.vertexCount}, (_, index) => ({
        index, branch: window.tremula.branchOf(index), along: window.tremula.alongOf(index),
        rest: window.tremula.vertex(index),
      })));
      await own.page.locator('#wind').fill('1');
      const pairs = tips(vertices, rest);
      assert.ok(pairs.length >= 3, `${pairs.length} tips found`);

      const normals = [];  // of each form at one instant
      for (const options of [{}, {compress: 'meshopt'}, {compress: 'none'}, {morphs: 'paired'}, {morphs: 'signed'}]) {
        const what = JSON.stringify(options);
        const {page, complaints, clips, targets} = await load(animate(plant, ['glb'], options).glb);
        assert.deepEqual(clips, [{name: 'wind loop', duration: settings.period}]);
        assert.equal(targets[0], 'mean lean');
        assert.match(targets[1], options.morphs === 'paired' ? /^mode 01 \d+\.\d{3} Hz \+$/ : /^mode 01 \d+\.\d{3} Hz$/);
        assert.equal(targets.filter((name) => name.startsWith('mode 21')).length, 0);

        const still = await page.evaluate(() => window.pose());
        assert.ok(Math.max(...vertices.map(({rest: at}, i) => distance(at, still.positions[i]))) < tolerance * height, what);
        const count = settings.period * settings.fps;
        for (const frame of [0, Math.floor(0.31 * count), Math.floor(0.77 * count)]) {
          const {positions} = await page.evaluate((time) => window.pose(time), poses[frame].time);
          const tipPositions = pairs.map(({index}) => positions[index]);
          assert.ok(largestError(pairs, tipPositions, poses[frame], rest) < tolerance, `${what} frame ${frame}`);
        }
        // Between the keys too, every vertex.
        for (const time of [0.123, 3.3333, 19.99]) {
          const {positions, normals: turned} = await page.evaluate((t) => window.pose(t), time);
          const wanted = await own.page.evaluate((t) => {
            window.tremula.setTime(t);
            return Array.from({length: window.tremula.vertexCount}, (_, i) => window.tremula.vertex(i));
          }, time);
          assert.equal(positions.length, wanted.length);
          const error = Math.max(...wanted.map((position, i) => distance(position, positions[i])));
          assert.ok(error < 2 * tolerance * height, `${what}: ${error} m of ${height} m at ${time} s`);
          if (time === 3.3333) normals.push(turned);
        }
        assert.deepEqual(complaints, []);
        await page.close();
      }
      for (const form of normals.slice(1))
        assert.ok(Math.max(...form.map((normal, i) => distance(normal, normals[0][i]))) < 0.1);
      await own.page.close();
    });
  }

  for (const plant of plants) {
    test(`${plant.name} on bones plays in three.js as the program poses it`, async () => {
      const rest = restNodes(plant), height = heightOf(rest), allowed = 0.005;
      for (const compress of ['quantised', 'meshopt', 'none']) {
        const options = {pose: 'bent', form: 'skin', tolerance: allowed, compress};
        const paths = animate({...plant, name: `${plant.name}-bones`}, ['glb', 'csv'], options);
        const poses = readPoses(paths.csv);
        const {page, complaints, clips, targets, joints} = await load(paths.glb);
        assert.deepEqual(clips, [{name: 'wind loop', duration: settings.period}]);
        assert.equal(targets.length, 0);
        assert.ok(joints > 1);
        const still = await page.evaluate(() => window.pose());
        // Tips are the vertices that stand where a node does.
        const pairs = rest.map((at, node) => ({
          node, index: still.positions.findIndex((position) => distance(position, at) < tolerance * height),
        })).filter(({index}) => index >= 0);
        assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
        const count = settings.period * settings.fps;
        let moved = 0;
        for (const frame of [0, 0.17, 0.31, 0.5, 0.77].map((part) => Math.floor(part * count))) {
          const {positions} = await page.evaluate((time) => window.pose(time), poses[frame].time);
          for (const {node, index} of pairs) {
            const error = distance(positions[index], poses[frame].nodes[node]);
            assert.ok(error < (allowed + tolerance) * height, `${compress} frame ${frame} node ${node}: ${error} m`);
            moved = Math.max(moved, distance(still.positions[index], positions[index]));
          }
        }
        assert.ok(moved > 2 * allowed * height, `moves by ${moved} m`);
        assert.deepEqual(complaints, []);
        await page.close();
      }
    });
  }
});
