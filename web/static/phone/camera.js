/** QR codes off the camera: by the browser's own BarcodeDetector where it has one, else by jsQR. */

const LOOK_EVERY_MS = 120;
const WIDEST_PX = 800; // a label at arm's length is still sharp, and jsQR takes a few milliseconds

/** @typedef {(image: HTMLCanvasElement) => Promise<string | null>} Reader */

/**
 * Show the camera in a video and look for QR codes until told to stop.
 * @param {HTMLVideoElement} video
 * @param {(text: string) => void} onText called for every code seen, the same one again and again
 * @param {AbortSignal} signal
 * @returns {Promise<void>} rejected with a DOMException where there is no camera, or it may not be used
 */
export async function watchCamera(video, onText, signal) {
  if (!navigator.mediaDevices) throw new DOMException("no secure page", "SecurityError");
  const wanted = { facingMode: "environment", width: { ideal: 1280 } };
  const [stream, read] = await Promise.all([navigator.mediaDevices.getUserMedia({ video: wanted }), qrReader()]);
  const stop = () => stream.getTracks().forEach((track) => track.stop());
  if (signal.aborted) return stop();
  signal.addEventListener("abort", stop);
  video.srcObject = stream;
  await video.play();
  const canvas = document.createElement("canvas");
  while (!signal.aborted) {
    const text = video.videoWidth ? await read(frameOf(video, canvas)) : null;
    if (text !== null && !signal.aborted) onText(text);
    await new Promise((resolve) => { setTimeout(resolve, LOOK_EVERY_MS); });
  }
}

/** @param {HTMLVideoElement} video @param {HTMLCanvasElement} canvas */
function frameOf(video, canvas) {
  const scale = Math.min(1, WIDEST_PX / video.videoWidth);
  canvas.width = Math.round(video.videoWidth * scale);
  canvas.height = Math.round(video.videoHeight * scale);
  canvas.getContext("2d", { willReadFrequently: true })?.drawImage(video, 0, 0, canvas.width, canvas.height);
  return canvas;
}

/** @returns {Promise<Reader>} */
export async function qrReader() {
  const Detector = /** @type {any} */ (globalThis).BarcodeDetector;
  const kinds = await Detector?.getSupportedFormats?.().catch(() => []);
  if (kinds?.includes("qr_code")) {
    const detector = new Detector({ formats: ["qr_code"] });
    return async (image) => (await detector.detect(image).catch(() => []))[0]?.rawValue ?? null;
  }
  const jsQR = await loadJsQR();
  return async (image) => {
    const { width, height } = image;
    const pixels = image.getContext("2d")?.getImageData(0, 0, width, height);
    return (pixels && jsQR(pixels.data, width, height, { inversionAttempts: "attemptBoth" })?.data) || null;
  };
}

/** @returns {Promise<(data: Uint8ClampedArray, width: number, height: number, options: object) => {data: string} | null>} */
async function loadJsQR() {
  const scope = /** @type {any} */ (globalThis);
  if (!scope.jsQR) {
    const script = document.createElement("script"); // it is no module
    script.src = "/vendor/jsqr/jsQR.js";
    await new Promise((resolve, reject) => {
      script.onload = resolve;
      script.onerror = () => reject(new DOMException("the reader of QR codes could not be loaded", "NetworkError"));
      document.head.append(script);
    });
  }
  return scope.jsQR;
}
