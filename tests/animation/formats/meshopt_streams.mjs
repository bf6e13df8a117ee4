// Streams as meshoptimizer packs and unpacks them: meshopt_streams.json is what this prints.
//
//     npm install meshoptimizer@1.3.0 && node meshopt_streams.mjs > meshopt_streams.json
import { createHash } from 'crypto';
import { MeshoptEncoder as encoder, MeshoptDecoder as decoder } from 'meshoptimizer';
await encoder.ready;
await decoder.ready;

let seed = 7;
const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
const text = (bytes) => Buffer.from(bytes).toString('base64');
const bytes = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
const made = [];
function add(name, mode, count, size, packed, filter) {
  const plain = new Uint8Array(count * size);
  decoder.decodeGltfBuffer(plain, count, size, packed, mode, filter);
  const told = filter ? { plain: text(plain) } : { sha256: createHash('sha256').update(plain).digest('hex') };
  made.push({ name, mode, filter: filter ?? 'NONE', count, byteStride: size, packed: text(packed), ...told });
}
const packed = (plain, count, size, mode, version) => encoder.encodeGltfBuffer(bytes(plain), count, size, mode, version);

for (const version of [0, 1]) {
  for (const [count, size] of [[1, 4], [17, 12], [300, 8], [530, 16]]) {
    const still = new Uint8Array(count * size), wild = still.map(() => 256 * random());
    const smooth = still.map((_, k) => ((k / size) | 0) * (k % size) / 3 + 3 * random());
    const steps = new Float32Array((count * size) / 4).map((_, k) => Math.sin(k / 50));
    for (const [name, one] of Object.entries({ still, wild, smooth, steps: bytes(steps) })) {
      if (name !== 'wild' || count < 100) add(`${name} ${version}`, 'ATTRIBUTES', count, size, packed(one, count, size, 'ATTRIBUTES', version));
    }
  }
}
const count = 40, four = new Float32Array(4 * count);
for (let k = 0; k < count; k++) {
  const given = [0, 0, 0, 0].map(() => random() - 0.5), length = Math.hypot(...given);
  four.set(given.map((one) => one / length), 4 * k);
}
const unit = four.map((one, k) => one / Math.hypot(...four.subarray(k - (k % 4), k - (k % 4) + 3)));
const tint = four.map(Math.abs);
for (const [filter, size, plain] of [
  ['OCTAHEDRAL', 4, encoder.encodeFilterOct(unit, count, 4, 8)],
  ['OCTAHEDRAL', 8, encoder.encodeFilterOct(unit, count, 8, 12)],
  ['QUATERNION', 8, encoder.encodeFilterQuat(four, count, 8, 12)],
  ['EXPONENTIAL', 16, encoder.encodeFilterExp(four, count, 16, 15)],
  ['COLOR', 4, encoder.encodeFilterColor(tint, count, 4, 8)],
  ['COLOR', 8, encoder.encodeFilterColor(tint, count, 8, 12)],
]) add(filter, 'ATTRIBUTES', count, size, packed(plain, count, size, 'ATTRIBUTES', 0), filter);

const side = 9, faces = [];
for (let k = 0; k < side * side - side; k++) {
  if (k % side < side - 1) faces.push(k, k + 1, k + side, k + 1, k + side + 1, k + side);
}
const shuffled = new Uint32Array(60).map(() => 70000 * random());
const around = [0, 1, 2, 2, 1, 3, 0, 1, 2, 9, 8, 7, 7, 8, 6];
for (const [name, one] of Object.entries({ grid: Uint32Array.from(faces), shuffled, around: Uint32Array.from(around) })) {
  const mode = name === 'grid' ? [2, 4] : name === 'around' ? [2] : [4];
  for (const size of mode) {
    const plain = size === 2 ? Uint16Array.from(one) : one;
    for (const kind of ['TRIANGLES', 'INDICES']) add(`${name} ${size}`, kind, one.length, size, packed(plain, one.length, size, kind));
  }
}

// The tower of samples.py.
const places = [], sides = [];
const corners = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
for (const height of [0, 1, 2]) for (const [x, y] of corners) places.push(x, height, -y);
for (const level of [0, 1]) for (const at of [0, 1, 2, 3]) {
  const a = 4 * level + at, b = 4 * level + ((at + 1) % 4);
  sides.push(a, b, b + 4, a, b + 4, a + 4);
}
sides.push(8, 9, 10, 8, 10, 11, 2, 1, 0, 3, 2, 0);
add('tower POSITION', 'ATTRIBUTES', 12, 12, packed(Float32Array.from(places), 12, 12, 'ATTRIBUTES', 0));
add('tower indices', 'TRIANGLES', 60, 2, packed(Uint16Array.from(sides), 60, 2, 'TRIANGLES'));
console.log('[\n' + made.map((one) => JSON.stringify(one)).join(',\n') + '\n]');
