// Reads arrays of NumPy (NEP 1): 32-bit floats, two dimensions, bottom row first as bakes write them. { width, height, values }
export function readNpy(buffer) {
  const view = new DataView(buffer);
  const isNpy = buffer.byteLength > 10 && view.getUint32(0) === 0x934e554d;
  const wide = isNpy && view.getUint8(6) > 1;
  const begin = wide ? 12 : 10;
  const length = isNpy ? (wide ? view.getUint32(8, true) : view.getUint16(8, true)) : 0;
  const header = new TextDecoder('latin1').decode(new Uint8Array(buffer, begin, Math.min(length, buffer.byteLength - begin)));
  const shape = /'shape': \((\d+), (\d+)\)/.exec(header);
  if (!isNpy || !shape || !header.includes("'descr': '<f4'") || !header.includes("'fortran_order': False")) {
    throw new Error('expected an array of 32-bit floats with two dimensions');
  }
  const [height, width] = shape.slice(1).map(Number);
  // Whatever the header's length, it ends at a multiple of 64 bytes.
  return { width, height, values: new Float32Array(buffer, begin + length, width * height) };
}
