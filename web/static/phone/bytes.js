/** Reading bytes one after the other, and the checksums that tags use. */

/** The bytes are not what they should be. */
export class BytesError extends Error {}

const UTF8 = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });

export class Reader {
  /** @param {Uint8Array} data */
  constructor(data) {
    this.data = data;
    this.view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    this.at = 0;
  }

  /** @param {number} count */
  take(count) {
    if (this.at + count > this.data.length) throw new BytesError(`ends after ${this.data.length} bytes`);
    this.at += count;
    return this.at - count;
  }

  u8() { return this.view.getUint8(this.take(1)); }
  i8() { return this.view.getInt8(this.take(1)); }
  u16() { return this.view.getUint16(this.take(2)); }
  i16() { return this.view.getInt16(this.take(2)); }
  u32() { return this.view.getUint32(this.take(4)); }

  f32() {
    const number = this.view.getFloat32(this.take(4));
    if (!Number.isFinite(number)) throw new BytesError("a number is not finite");
    return number;
  }

  /** @param {number} count */
  bytes(count) {
    const from = this.take(count);
    return this.data.subarray(from, from + count);
  }

  /** A text after a byte that says how many bytes it has. @param {number} [most] */
  text(most = 255) {
    const count = this.u8();
    if (count > most) throw new BytesError("a text is too long");
    try {
      return UTF8.decode(this.bytes(count));
    } catch (error) {
      throw error instanceof BytesError ? error : new BytesError("a text is damaged");
    }
  }
}

/** CRC-16 (CCITT, from 0xFFFF), as binascii.crc_hqx. @param {Iterable<number>} data */
export function crc16(data) {
  let crc = 0xffff;
  for (const byte of data) {
    crc ^= byte << 8;
    for (let bit = 0; bit < 8; bit += 1) crc = crc & 0x8000 ? ((crc << 1) ^ 0x1021) & 0xffff : (crc << 1) & 0xffff;
  }
  return crc;
}

/** CRC-32 of a text's bytes, as zlib.crc32. @param {string} text */
export function crc32(text) {
  let crc = 0xffffffff;
  for (const byte of new TextEncoder().encode(text)) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return (crc ^ 0xffffffff) >>> 0;
}
