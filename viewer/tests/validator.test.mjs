// The Khronos validator judges the .glb files that the program writes. It does not know EXT_meshopt_compression: of a
// packed file it sees all but the buffers.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';
import validator from 'gltf-validator';
import {animate, avenue, plants} from './support.mjs';

const errorSeverity = 0, warningSeverity = 1;

const onBones = {pose: 'bent', form: 'skin'};

async function validate(bytes) {
  const report = await validator.validateBytes(new Uint8Array(bytes), {maxIssues: 0});
  return report.issues.messages.filter(({severity}) => severity === errorSeverity || severity === warningSeverity);
}

for (const plant of plants) {
  for (const [kind, options] of [
    ['in wind', {}], ['without wind', {'wind-speed': 0}], ['with one mode', {modes: 1}],
    ['in pairs', {morphs: 'paired'}], ['with signed weights', {morphs: 'signed'}], ['packed', {compress: 'meshopt'}],
    ['in floats', {compress: 'none'}], ['on bones', onBones], ['on bones, packed', {...onBones, compress: 'meshopt'}],
    ['on bones in floats', {...onBones, compress: 'none'}],
  ]) {
    test(`${plant.name} ${kind} has no error and no warning`, async () => {
      assert.deepEqual(await validate(readFileSync(animate(plant, ['glb'], options).glb)), []);
    });
  }
}

test('several instances of a plant have no error and no warning', (t) => {
  const written = avenue();
  if (!written) return t.skip('the examples were not built');
  return validate(readFileSync(written.glb)).then((issues) => assert.deepEqual(issues, []));
});

test('the validator would see a spoilt file', async () => {
  const bytes = readFileSync(animate(plants[0], ['glb']).glb);
  const spoilt = Buffer.from(bytes);
  spoilt.writeFloatLE(Number.NaN, bytes.length - 4);
  assert.notDeepEqual(await validate(spoilt), []);
});
