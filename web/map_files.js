// Maps as files on the caretaker's page: saves one to the phone, imports one from the phone.

import { button, element } from "./elements.js";

const ZIP = "application/zip";
const MEGA = 1e6;
const UTF8 = 0x800;
const OLDEST = 0x21; // 1980-01-01 in a zip file's format

/** `on`: report(text), send(path, request), most() bytes. */
export class MapFiles {
  #texts;
  #on;
  #field = element("input");
  root; // a button

  constructor(texts, on) {
    this.#texts = texts;
    this.#on = on;
    this.#field.type = "file";
    this.#field.multiple = true;
    this.#field.addEventListener("change", () => this.#send([...this.#field.files]));
    this.root = button(texts.label("maps_import"), () => this.#field.click(), "import");
  }

  async #send(files) {
    if (files.length === 0) return;
    const most = this.#on.most();
    const bytes = files.reduce((sum, { size }) => sum + size, 0);
    if (bytes > most) {
      const fields = { mb: this.#texts.number(most / MEGA, 0) };
      this.#on.report(this.#texts.label("maps_import_large", fields));
    } else {
      this.#on.report(this.#texts.label("maps_importing"));
      const body = await this.#packed(files);
      const request = { method: "POST", headers: { "Content-Type": ZIP }, body };
      if (body) await this.#on.send("/maps/import", request);
    }
    this.#field.value = ""; // so that the same file can be chosen again
  }

  async #packed(files) {
    try {
      return files.length === 1 ? await files[0].arrayBuffer() : await zipOf(files);
    } catch (error) {
      console.warn(`maps: ${error.message}`);
      this.#on.report(this.#texts.label("maps_import_unread"));
      return null;
    }
  }
}

/** Downloads the file at this address to the phone. */
export function download(address) {
  const link = element("a");
  link.href = address;
  link.download = "";
  link.click();
}

/** Numbers of 2 and 4 bytes, in the order of `form`. */
function record(form, ...values) {
  const sizes = [...form].map(Number);
  const view = new DataView(new ArrayBuffer(sizes.reduce((sum, size) => sum + size, 0)));
  let at = 0;
  for (const [place, size] of sizes.entries()) {
    if (size === 2) view.setUint16(at, values[place], true);
    else view.setUint32(at, values[place], true);
    at += size;
  }
  return view;
}

/** An uncompressed zip file of them. */
async function zipOf(files) {
  const pieces = [];
  const table = [];
  let at = 0;
  for (const file of files) {
    const name = new TextEncoder().encode(file.name);
    const bytes = new Uint8Array(await file.arrayBuffer());
    const sum = sumOf(bytes);
    const facts = [20, UTF8, 0, 0, OLDEST, sum, bytes.length, bytes.length, name.length, 0];
    const head = record("42222244422", 0x04034b50, ...facts);
    table.push(record("42222224442222244", 0x02014b50, 20, ...facts, 0, 0, 0, 0, at), name);
    pieces.push(head, name, bytes);
    at += head.byteLength + name.length + bytes.length;
  }
  const long = table.reduce((sum, { byteLength }) => sum + byteLength, 0);
  const end = record("42222442", 0x06054b50, 0, 0, files.length, files.length, long, at, 0);
  return new Blob([...pieces, ...table, end]).arrayBuffer();
}

/** CRC-32. */
function sumOf(bytes) {
  const table = Uint32Array.from({ length: 256 }, (_, number) => {
    let value = number;
    for (let bit = 0; bit < 8; bit++) value = (value >>> 1) ^ (value & 1 ? 0xedb88320 : 0);
    return value;
  });
  let sum = ~0;
  for (const byte of bytes) sum = (sum >>> 8) ^ table[(sum ^ byte) & 0xff];
  return ~sum >>> 0;
}
