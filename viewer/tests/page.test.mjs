// The page in a real browser: its vertices against the node poses that the program writes as .csv, and its controls.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {after, before, describe, test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {
  animate, animateDrift, animateField, animateImpressions, animateVolume, avenue, distance, drifts, heightOf,
  largestError, launchBrowser, meadow, needsBrowser, openPage, paintedTrees, plants, readPoses, restNodes, screenshotPath, settings, tips, tolerance, volumes,
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
const grouped = (count) => count.toLocaleString('en').replaceAll(',', ' ');

// Two triangles from one point of a strand to the next, which meet in a diagonal: everything else is torn.
const piecesOfRibbons = () => {
  const torn = [];
  let pieces = 0;
  for (const {geometry: {index: {array: index}, attributes: {position, tangent, plant}}} of window.tremula.meshes) {
    const read = (attribute, corner) => [0, 1, 2].map((i) => attribute.array[attribute.itemSize * corner + i]);
    const side = (corner) => Math.sign(tangent.array[4 * corner + 3]);
    const apart = (a, b) => a.map((x, i) => b[i] - x);
    const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
    const byPoints = new Map();
    for (let i = 0; i < index.length; i += 3) {
      const corners = [...index.subarray(i, i + 3)], points = [...new Set(corners.map((c) => c >> 1))].sort((a, b) => a - b);
      byPoints.set(`${points}`, [...(byPoints.get(`${points}`) ?? []), corners]);
    }
    const reached = new Set();
    for (const [key, triangles] of byPoints) {
      const [first, second] = key.split(',').map(Number), shared = triangles[0].filter((c) => triangles[1]?.includes(c));
      const alone = triangles.flat().filter((c) => !shared.includes(c));
      const way = apart(read(position, 2 * first), read(position, 2 * second));
      const whole = second === first + 1 && triangles.length === 2 && shared.length === 2 &&
          alone[0] >> 1 !== alone[1] >> 1 && side(alone[0]) !== side(alone[1]) && side(shared[0]) !== side(shared[1]) &&
          `${read(plant, 2 * first)}` === `${read(plant, 2 * second)}` &&
          dot(way, read(tangent, 2 * first)) > 0 && dot(way, read(tangent, 2 * second)) > 0;
      if (!whole && torn.length < 5) torn.push(`${key}: ${triangles.join(' and ')}`);
      reached.add(first).add(second);
      ++pieces;
    }
    for (let point = 0; point < position.count / 2; ++point)
      if (!reached.has(point) && torn.length < 5) torn.push(`${point} is reached by none`);
  }
  return {pieces, torn};
};

// What is to be seen on a page that nobody plays; it complains of nothing and asks for nothing else.
async function onPage(browser, html, viewport, look) {
  const {page, complaints, requests} = await openPage(browser, {viewport, reducedMotion: 'reduce'});
  const url = pathToFileURL(html).href;
  await page.goto(url);
  await page.evaluate(() => window.tremula.ready);
  await look(page);
  assert.deepEqual(complaints, []);
  assert.deepEqual(requests, [url]);
  await page.close();
}

// The picture at the begin of the loop: the same at its end, and another between.
async function firstOfLoop(page, period, screenshot) {
  const first = await page.evaluate(pictureAt, 0);
  assert.equal(await page.evaluate(pictureAt, period), first);
  assert.notEqual(await page.evaluate(pictureAt, 0.37 * period), first);
  await page.screenshot({path: screenshotPath(screenshot)});
  return first;
}

async function standsStillInStillAir(page, inWind) {
  await setSlider(page, 'wind', 0);
  const still = await page.evaluate(pictureAt, 0);
  assert.equal(await page.evaluate(pictureAt, 2.2), still);
  assert.notEqual(still, inWind);
}

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

  for (const plant of plants) {
    test(`${plant.name} on bones stands where the poses say, and no wind or mode stretches it`, async () => {
      const allowed = 0.005, height = heightOf(restNodes(plant));
      const paths = animate({...plant, name: `${plant.name}-bones`}, ['html', 'csv'], {pose: 'bent', tolerance: allowed});
      const poses = readPoses(paths.csv), rest = restNodes(plant);
      const {page, complaints} = await openPage(browser, {viewport: {width: 1000, height: 700}});
      await page.goto(pathToFileURL(paths.html).href);
      await page.evaluate(() => window.tremula.ready);
      await page.evaluate(() => window.tremula.pause());
      const text = () => page.locator('#wind-text').textContent();
      assert.equal(await text(), `${plant.wind.toFixed(1)} m/s`);

      await setSlider(page, 'wind', 0);
      assert.equal(await text(), 'still air');
      const vertices = await page.evaluate(allVertices), pairs = tips(vertices, rest);
      assert.ok(pairs.length >= 3, `${pairs.length} tips found`);
      const at = (time) => page.evaluate(positionsAt, [time, vertices.map((_, i) => i)]);
      const still = vertices.map((vertex) => vertex.rest);
      await setSlider(page, 'wind', 1);
      const count = settings.period * settings.fps;
      for (const frame of [0, Math.floor(0.31 * count), Math.floor(0.77 * count)]) {
        const positions = await page.evaluate(positionsAt, [poses[frame].time, pairs.map(({index}) => index)]);
        assert.ok(largestError(pairs, positions, poses[frame], rest) < allowed + tolerance, `frame ${frame}`);
      }

      // Rings of bark and leaves keep their size, in whatever wind and under each mode alone.
      const swelling = (positions) => {
        let worst = 1;
        for (let i = 1; i < vertices.length; ++i) {
          const [a, b] = [vertices[i - 1], vertices[i]];
          const length = distance(still[i - 1], still[i]);
          if (a.branch !== b.branch || a.along !== b.along || length < 10 * tolerance * height) continue;
          const ratio = distance(positions[i - 1], positions[i]) / length;
          worst = Math.max(worst, ratio, 1 / ratio);
        }
        return worst;
      };
      const time = 3.3, farthest = (from, to) => Math.max(...from.map((p, i) => distance(p, to[i])));
      const full = await at(time), sway = farthest(still, full);
      assert.ok(sway > 2 * allowed * height, `moves by ${sway} m`);
      assert.ok(swelling(full) < 1.02);
      await setSlider(page, 'wind', 0.71);
      assert.match(await page.locator('#shown').textContent(), /^50 % wind loop \(\d+ m\/s\), 50 % still air$/);
      const half = await at(time);
      assert.ok(swelling(half) < 1.02);
      const middle = full.map((p, i) => p.map((x, k) => (x + still[i][k]) / 2));
      assert.ok(farthest(half, middle) < 0.2 * sway, `${farthest(half, middle)} m of ${sway} m`);
      await setSlider(page, 'wind', 1);

      // To first order the shapes add up to the clip: it is what is left without one, and that one, about the lean.
      await page.locator('summary').click();
      const rows = page.locator('#mode-list button');
      const toggle = async (i) => { await rows.nth(i).click(); await page.waitForTimeout(600); };
      await toggle(0);
      const without = await at(time);
      await toggle(0);
      assert.ok(farthest(await at(time), full) === 0, 'switched on again it is the clip');
      await rows.nth(0).dblclick();
      const alone = await at(time);
      assert.ok(swelling(alone) < 1.02);
      await toggle(0);
      const lean = await at(time);
      assert.ok(farthest(alone, lean) > 0);
      const sum = full.map((_, i) => without[i].map((x, k) => x + alone[i][k] - lean[i][k]));
      assert.ok(farthest(sum, full) < 0.1 * farthest(lean, full) + allowed * height,
                `${farthest(sum, full)} m of ${farthest(lean, full)} m`);
      await page.screenshot({path: screenshotPath(`${plant.name}-bones`)});
      assert.deepEqual(complaints, []);
      await page.close();
    });
  }

  test('several winds are blended, and named', async () => {
    const input = {...plants[0], name: 'clips'};
    const {html} = animate(input, ['html'], {pose: 'bent', clip: ['calm:2', 'gale:10'], 'wind-speed': undefined});
    const {page, complaints} = await openPage(browser, {viewport: {width: 390, height: 844}});
    await page.goto(pathToFileURL(html).href);
    await page.evaluate(() => window.tremula.ready);
    await page.evaluate(() => window.tremula.pause());
    const text = () => page.locator('#wind-text').textContent();
    const last = await page.evaluate(() => window.tremula.vertexCount - 1);
    const at = async (wind) => {
      await setSlider(page, 'wind', wind);
      return (await page.evaluate(positionsAt, [5, [last]]))[0];
    };
    const gale = await at(1);
    assert.equal(await text(), '10.0 m/s');
    const between = await at(0.72);
    assert.equal(await text(), '7.2 m/s');
    assert.equal(await page.locator('#shown').textContent(), '50 % gale (10 m/s), 50 % calm (2 m/s)');
    const calm = await at(0.2);
    assert.equal(await text(), '2.0 m/s');
    const still = await at(0);
    assert.ok(distance(still, calm) > 0);
    const middle = gale.map((x, k) => (x + calm[k]) / 2);
    assert.ok(distance(between, middle) < 0.2 * distance(calm, gale));
    assert.match(await page.locator('#wind').locator('..').getAttribute('title'), /calm \(2 m\/s\), gale \(10 m\/s\)/);
    assert.deepEqual(complaints, []);
    await page.screenshot({path: screenshotPath('clips-on-a-phone')});
    await page.close();
  });

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

  test('the graphics card puts blades where the library poses them', async (t) => {
    const written = meadow();
    if (!written) return t.skip('the examples were not built');
    const {page, complaints} = await openPage(browser, {viewport: {width: 500, height: 350}, reducedMotion: 'reduce'});
    await page.goto(pathToFileURL(written.html).href);
    await page.evaluate(() => window.tremula.ready);
    await page.evaluate(() => window.tremula.pause());
    const times = [...new Set(written.posed.map(({time}) => time))];
    assert.equal(times.length, 3);
    const height = heightOf(written.posed.map(({place}) => place));
    const found = new Map();
    for (const time of times) {
      const wanted = written.posed.filter((one) => one.time === time);
      const places = await page.evaluate(positionsAt, [time, wanted.map(({index}) => index)]);
      found.set(time, places);
      places.forEach((place, i) => {
        const off = distance(place, wanted[i].place);
        assert.ok(off < 1e-3 * height, `vertex ${wanted[i].index} at ${time} s: ${place} for ${wanted[i].place}`);
      });
    }
    const moved = Math.max(...found.get(times[0]).map((place, i) => distance(place, found.get(times[1])[i])));
    assert.ok(moved > 0.02 * height, `${moved} m: this would show nothing`);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  for (const [what, pages, count, least] of [['what drifts', drifts, 4, 1], ['painted trees', paintedTrees, 2, 0.02],
                                             ['volumes', volumes, 3, 1e-3]]) {
    // Of plants that bend, as good as a card's sines are, by the height of the plant.
    const allowed = (kind) => ({rice: 3e-4, moss: 1e-5, fur: 1.5e-5})[kind] ?? 1e-4;
    test(`the graphics card puts ${what} where the library does`, async (t) => {
      const written = pages();
      if (!written) return t.skip('the examples were not built');
      assert.equal(written.length, count);
      for (const {kind, html, posed} of written) {
        const {page, complaints} = await openPage(browser, {viewport: {width: 300, height: 200}, reducedMotion: 'reduce'});
        await page.goto(pathToFileURL(html).href);
        await page.evaluate(() => window.tremula.ready);
        const times = [...new Set(posed.map(({time}) => time))];
        assert.equal(times.length, 3);
        const found = [];
        for (const time of times) {
          const wanted = posed.filter((one) => one.time === time);
          const places = await page.evaluate(positionsAt, [time, wanted.map(({index}) => index)]);
          found.push(places);
          places.forEach((place, i) => {
            const off = distance(place, wanted[i].place);
            assert.ok(off < allowed(kind), `${kind} ${wanted[i].index} at ${time} s: ${place} for ${wanted[i].place}`);
          });
        }
        const moved = Math.max(...found[0].map((place, i) => distance(place, found[1][i])));
        assert.ok(moved > least, `${moved} m: this would show nothing`);
        assert.deepEqual(complaints, []);
        await page.close();
      }
    });
  }

  for (const [species, half] of [['rice', 0.4], ['moss', 0.02], ['fur', 0.02]]) {
    test(`${species} as strands sways, closes, and stands still in still air`, async () => {
      const {html, report} = animateVolume(species, half);
      await onPage(browser, html, {width: 300, height: 210}, async (page) => {
        assert.equal(await page.locator('#facts').textContent(), `6 s loop · ${grouped(report.page.strands)} strands`);
        const {pieces, torn} = await page.evaluate(piecesOfRibbons);
        assert.ok(pieces > 1000, `${pieces} pieces of ribbons`);
        assert.deepEqual(torn, []);
        const first = await firstOfLoop(page, 6, `strands-${species}`);
        await standsStillInStillAir(page, first);
      });
    });
  }

  for (const shape of ['oak', 'pine']) {
    test(`painted trees (${shape}) sway, close, and stand still in still air`, async () => {
      const {html, report} = animateImpressions(shape);
      await onPage(browser, html, {width: 360, height: 250}, async (page) => {
        assert.equal(report.page.trees, 4);
        assert.equal(await page.evaluate(() => window.tremula.vertexCount), report.page.vertices);
        assert.equal(await page.locator('#facts').textContent(), '6 s loop · 4 painted trees');
        const first = await firstOfLoop(page, 6, `painted-${shape}`);
        await standsStillInStillAir(page, first);
      });
    });
  }

  for (const kind of ['snow', 'rain', 'leaves', 'seeds']) {
    test(`${kind} drifts, closes, and offers no other wind`, async () => {
      const {html, report} = animateDrift(kind);
      await onPage(browser, html, {width: 600, height: 420}, async (page) => {
        const told = {snow: 'flakes', rain: 'drops', leaves: 'leaves', seeds: 'seeds'}[kind];
        assert.ok(report.page.seen > 100, `${report.page.seen}`);
        assert.equal(await page.locator('#facts').textContent(), `6 s loop · ${grouped(Math.round(report.page.seen))} ${told}`);
        assert.equal(await page.locator('#shown').textContent(), 'in the wind of 6.0 m/s, which made these paths');
        assert.ok(await page.locator('#wind').isHidden());
        assert.ok(await page.locator('#modes').isHidden());
        await firstOfLoop(page, 6, kind);
      });
    });
  }

  test('a meadow moves, closes, and stands upright in still air', async () => {
    const {html, report} = animateField('meadow');
    await onPage(browser, html, {width: 600, height: 420}, async (page) => {
      await page.evaluate(() => window.tremula.pause());
      const blades = report.page.blades;
      assert.ok(blades > 1000, `${blades} blades`);
      assert.equal(await page.evaluate(() => window.tremula.vertexCount), report.page.vertices);
      assert.equal(await page.locator('#facts').textContent(), `6 s loop · ${grouped(blades)} blades`);
      assert.ok(await page.locator('#modes').isHidden());
      await firstOfLoop(page, await page.evaluate(() => window.tremula.period), 'meadow');

      // Without wind no time changes anything; more wind bends more.
      const some = Array.from({length: 30}, (_, i) => Math.floor((i + 0.5) * report.page.vertices / 30));
      const at = async (wind, time) => {
        await setSlider(page, 'wind', wind);
        return page.evaluate(positionsAt, [time, some]);
      };
      const still = await at(0, 1);
      assert.deepEqual(await at(0, 3), still);
      const bend = async (wind) => (await at(wind, 1)).reduce((sum, p, i) => sum + distance(p, still[i]), 0);
      const usual = await bend(1);
      assert.ok(usual > 0 && await bend(2) > usual);
    });
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
