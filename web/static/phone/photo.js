/** Photos as they are kept and sent: small enough for a bad link and a full phone, large enough to see what there is. */

const LONGEST_PX = 1600;
const QUALITY = 0.8;

/** The picture as a JPEG of at most 1600 pixels; as it is where this browser cannot read it. @param {Blob} picture @returns {Promise<Blob>} */
export async function smaller(picture) {
  try {
    const image = await createImageBitmap(picture, { imageOrientation: "from-image" });
    const scale = Math.min(1, LONGEST_PX / Math.max(image.width, image.height));
    const canvas = document.createElement("canvas");
    canvas.width = Math.round(image.width * scale);
    canvas.height = Math.round(image.height * scale);
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    image.close();
    const made = await new Promise((resolve) => { canvas.toBlob(resolve, "image/jpeg", QUALITY); });
    return made ?? picture;
  } catch {
    return picture;
  }
}
