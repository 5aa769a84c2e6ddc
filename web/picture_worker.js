// The camera picture's thread: receives, decodes, draws, acknowledges; reports the age to the page.

import { Wire } from "./wire.js";

// u32 LE sequence, u32 LE age in ms when sent.
const HEADER_BYTES = 8;
const SILENCE_MS = 5000;
const TICK_MS = 100;

let canvas = null;
let surface = null;

const wire = new Wire("/ws/video", SILENCE_MS, { message: receive });

onmessage = (event) => {
  canvas = event.data;
  surface = canvas.getContext("bitmaprenderer");
  wire.tick(performance.now());
  setInterval(() => wire.tick(performance.now()), TICK_MS);
};

async function receive(data) {
  const header = new DataView(data, 0, HEADER_BYTES);
  const sequence = header.getUint32(0, true);
  const bornMs = performance.now() - header.getUint32(4, true);
  try {
    await draw(new Uint8Array(data, HEADER_BYTES));
    postMessage(performance.now() - bornMs);
  } catch (error) {
    console.warn(`picture ${sequence} is not a readable JPEG: ${error.message}`);
  }
  // For a bad picture too, else the next one would never come.
  wire.send(String(sequence));
}

async function draw(jpeg) {
  const bitmap = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
  if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
  if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
  surface.transferFromImageBitmap(bitmap);
}
