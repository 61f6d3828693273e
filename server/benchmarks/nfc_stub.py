"""What stands in for Web NFC, which only Chrome on Android has: chips come to the page by a script."""

NFC = """
globalThis.NDEFReader = class {
  async scan() { globalThis.nfc = this; }
  async write(message) {
    const records = message.records.map((r) => typeof r.data === "string" ? r.data : [...r.data]);
    Object.assign(globalThis, globalThis.tears ? { torn: records } : { written: records });
    if (globalThis.tears) throw new DOMException("gone", "NetworkError");
  }
};
globalThis.touchChip = (link, payload) => nfc.onreading({ message: { records: [
  ...(link ? [{ recordType: "url", data: new DataView(new TextEncoder().encode(link).buffer) }] : []),
  ...(payload ? [{ recordType: "u.io:t", data: new DataView(Uint8Array.from(payload).buffer) }] : []),
] } });
"""
"""Script, to run before a page's own: ``touchChip(link, payload)`` holds a chip to the phone.

What the page writes is in ``written``, or in ``torn`` where ``tears`` is set: the chip was gone before
all was written.
"""
