// The .glb as any other application with three.js plays it, against the page and against the poses.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, before, describe, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';
import {build} from 'vite';
import {
  animate, distance, largestError, launchBrowser, needsBrowser, openPage, plants, readPoses, restNodes, settings, tips,
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

  for (const plant of plants) {
    test(`${plant.name} plays in three.js as in the page`, async () => {
      const paths = animate(plant, ['glb', 'html', 'csv']);
      const poses = readPoses(paths.csv), rest = restNodes(plant);
      const {page, complaints} = await openPage(browser);
      await page.addScriptTag({content: player});
      const {clips, targets} = await page.evaluate((bytes) => window.load(bytes),
                                                   readFileSync(paths.glb).toString('base64'));
      assert.deepEqual(clips, [{name: 'wind loop', duration: settings.period}]);
      assert.equal(targets[0], 'mean lean');
      assert.match(targets[1], /^mode 01 \d+\.\d{3} Hz \+$/);
      assert.match(targets[2], /^mode 01 \d+\.\d{3} Hz -$/);

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

      const count = settings.period * settings.fps;
      for (const frame of [0, Math.floor(0.31 * count), Math.floor(0.77 * count)]) {
        const positions = await page.evaluate((time) => window.pose(time), poses[frame].time);
        const tipPositions = pairs.map(({index}) => positions[index]);
        assert.ok(largestError(pairs, tipPositions, poses[frame], rest) < 0.01, `frame ${frame}`);
      }
      // Between the keys too, every vertex.
      for (const time of [0.123, 3.3333, 11.07, 19.99]) {
        const positions = await page.evaluate((t) => window.pose(t), time);
        const wanted = await own.page.evaluate((t) => {
          window.tremula.setTime(t);
          return Array.from({length: window.tremula.vertexCount}, (_, i) => window.tremula.vertex(i));
        }, time);
        const largest = Math.max(...wanted.map((position, i) => distance(position, vertices[i].rest)));
        const error = Math.max(...wanted.map((position, i) => distance(position, positions[i])));
        assert.equal(positions.length, wanted.length);
        assert.ok(error < 0.001 * largest, `${error} m of ${largest} m at ${time} s`);
      }
      assert.deepEqual(complaints, []);
      await Promise.all([page.close(), own.page.close()]);
    });
  }
});
