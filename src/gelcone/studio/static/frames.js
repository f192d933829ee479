// A frame of the server: length of the head, the head as JSON, then the arrays at multiples of eight bytes.
const TYPES = { f4: Float32Array, u1: Uint8Array };

export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, type, at, count] of head.arrays) arrays[name] = new TYPES[type](buffer, 4 + length + at, count);
  return [head, arrays];
}
