// The page in a real browser: its vertices against the node poses that the program writes as .csv, and its controls.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {after, before, describe, test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {
  animate, avenue, distance, largestError, launchBrowser, needsBrowser, openPage, plants, readPoses, restNodes, screenshotPath,
  settings, tips, tolerance,
} from './support.mjs';

// In the page: positions of these vertices at this instant.
const positionsAt = ([time, indices]) => {
  window.tremula.setTime(time);
  return indices.map((i) => window.tremula.vertex(i));
};
const allVertices = () => Array.from({length: window.tremula.vertexCount}, (_, index) => ({
  index, branch: window.tremula.branchOf(index), along: window.tremula.alongOf(index),
  rest: window.tremula.vertex(index),
}));
const pictureAt = (time) => {
  window.tremula.setTime(time);
  return document.querySelector('canvas').toDataURL();
};
const setSlider = (page, id, value) => page.locator(`#${id}`).fill(String(value));

describe('the page', needsBrowser, () => {
  let browser;
  before(async () => { browser = await launchBrowser(); });
  after(() => browser?.close());

  for (const plant of plants) {
    test(`${plant.name} stands where the poses say`, async () => {
      const paths = animate(plant, ['html', 'csv']);
      const poses = readPoses(paths.csv), rest = restNodes(plant);
      const {page, complaints, requests} = await openPage(browser, {viewport: {width: 1000, height: 700}});
      const url = pathToFileURL(paths.html).href;
      await page.goto(url);
      await page.evaluate(() => window.tremula.ready);
      await page.evaluate(() => window.tremula.pause());
      assert.equal(await page.evaluate(() => window.tremula.period), settings.period);

      await setSlider(page, 'wind', 0);
      const pairs = tips(await page.evaluate(allVertices), rest);
      assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
      await setSlider(page, 'wind', 1);

      const indices = pairs.map(({index}) => index);
      const count = settings.period * settings.fps;
      for (const frame of [0, Math.floor(0.31 * count), Math.floor(0.77 * count)]) {
        const pose = poses[frame];
        const positions = await page.evaluate(positionsAt, [pose.time, indices]);
        assert.ok(largestError(pairs, positions, pose, rest) < tolerance, `frame ${frame}`);
        await page.screenshot({path: screenshotPath(`${plant.name}-${pose.time.toFixed(1)}s`)});
      }
      // Between two frames the tips are half way.
      const halfway = await page.evaluate(positionsAt, [(poses[8].time + poses[9].time) / 2, indices]);
      const between = {nodes: poses[8].nodes.map((node, i) => node.map((x, k) => (x + poses[9].nodes[i][k]) / 2))};
      assert.ok(largestError(pairs, halfway, between, rest) < tolerance, 'between frames');

      // The loop closes: the same numbers, and the same picture.
      assert.deepEqual(await page.evaluate(positionsAt, [settings.period, indices]),
                       await page.evaluate(positionsAt, [0, indices]));
      const first = await page.evaluate(pictureAt, 0);
      assert.equal(await page.evaluate(pictureAt, settings.period), first);
      assert.notEqual(await page.evaluate(pictureAt, 0.31 * settings.period), first);

      assert.deepEqual(complaints, []);
      assert.deepEqual(requests, [url]);
      await page.close();
    });
  }

  test('every instance stands in its place and moves in its own time', async (t) => {
    const written = avenue();
    if (!written) return t.skip('the examples were not built');
    const {page, complaints} = await openPage(browser, {viewport: {width: 1000, height: 700}});
    await page.goto(pathToFileURL(written.html).href);
    await page.evaluate(() => window.tremula.ready);
    await page.evaluate(() => window.tremula.pause());
    const [each, period] = await page.evaluate((n) => [window.tremula.vertexCount / n, window.tremula.period],
                                               written.instances.length);
    assert.ok(Number.isInteger(each));
    const some = Array.from({length: 40}, (_, i) => Math.floor((i + 0.5) * each / 40));
    for (const time of [0, 0.31 * period, 0.9 * period]) {
      for (const [i, {x, y, turn, scale, timeShift}] of written.instances.entries()) {
        const found = await page.evaluate(positionsAt, [time, some.map((v) => i * each + v)]);
        const first = await page.evaluate(positionsAt, [(time + timeShift) % period, some]);
        const cosine = scale * Math.cos(turn), sine = scale * Math.sin(turn);
        first.forEach(([px, py, pz], v) => {
          const wanted = [x + cosine * px - sine * py, y + sine * px + cosine * py, scale * pz];
          assert.ok(distance(found[v], wanted) < 1e-4, `instance ${i}, vertex ${v}: ${found[v]} for ${wanted}`);
        });
      }
    }
    await page.screenshot({path: screenshotPath('avenue')});
    assert.deepEqual(complaints, []);
    await page.close();
  });

  test('the controls do what they say', async () => {
    const {page, complaints} = await openPage(browser, {viewport: {width: 390, height: 844}});
    await page.goto(pathToFileURL(animate(plants[0], ['html']).html).href);
    await page.evaluate(() => window.tremula.ready);
    const time = () => page.locator('#time').inputValue().then(Number);

    // It plays from the start; space stops it and lets it go on.
    const playing = await time();
    await page.waitForFunction((before) => Number(document.getElementById('time').value) !== before, playing);
    await page.keyboard.press(' ');
    const stopped = await time();
    await page.waitForTimeout(300);
    assert.equal(await time(), stopped);
    await page.keyboard.press(' ');
    await page.waitForFunction((before) => Number(document.getElementById('time').value) !== before, stopped);
    await page.locator('#play').click();

    await setSlider(page, 'time', 7.5);
    assert.equal(await time(), 7.5);
    const last = await page.evaluate(() => window.tremula.vertexCount - 1);
    const position = () => page.evaluate((i) => window.tremula.vertex(i), last);
    const moved = await position();

    // Twice the wind, four times the load and the displacement.
    await setSlider(page, 'wind', 0);
    const rest = await position();
    await setSlider(page, 'wind', 2);
    const stormy = await position();
    assert.ok(distance(moved, rest) > 0);
    assert.ok(distance(stormy.map((x, k) => rest[k] + (x - rest[k]) / 4), moved) < 1e-5 * distance(moved, rest) + 1e-7);
    await setSlider(page, 'wind', 1);

    // A mode that is switched off moves nothing; alone it leaves the others out.
    await page.locator('summary').click();
    const rows = page.locator('#mode-list button');
    const on = () => rows.evaluateAll((all) => all.filter((row) => row.ariaPressed === 'true').length);
    // Twenty modes, and three static shapes for the modes left out, which are no modes.
    const shapes = 23;
    assert.match(await page.locator('#facts').textContent(), /^20 s loop · 20 modes · 1\.57–2\.87 Hz$/);
    const labels = await rows.allTextContents();
    assert.match(labels[19], /^202\.87 Hz$/);
    assert.deepEqual(labels.slice(20), ['s1static', 's2static', 's3static']);
    assert.equal(await rows.count(), shapes);
    await rows.nth(2).click();
    assert.equal(await on(), shapes - 1);
    assert.notDeepEqual(await position(), moved);
    await page.waitForTimeout(600);
    await rows.nth(2).click();
    assert.deepEqual(await position(), moved);
    await page.waitForTimeout(600);
    await rows.nth(4).dblclick();
    assert.equal(await on(), 1);
    await page.screenshot({path: screenshotPath('phone')});
    assert.deepEqual(complaints, []);
  });

  test('a plant without wind is shown, and stands still', async () => {
    const {page, complaints} = await openPage(browser, {viewport: {width: 300, height: 300}});
    await page.goto(pathToFileURL(animate(plants[1], ['html'], {'wind-speed': 0}).html).href);
    await page.evaluate(() => window.tremula.ready);
    assert.equal(await page.evaluate(pictureAt, 5), await page.evaluate(pictureAt, 0));
    assert.deepEqual(complaints, []);
    await page.close();
  });

  test('a page whose data is damaged says so', async () => {
    const {page} = await openPage(browser);
    const {html} = animate(plants[0], ['html']);
    writeFileSync(html, readFileSync(html, 'utf8').replace('text/plain">H4sI', 'text/plain">AAAA'));
    await page.goto(pathToFileURL(html).href);
    await page.locator('#message:visible').waitFor();
    assert.match(await page.locator('#message').textContent(), /cannot show its plant/);
  });
});
