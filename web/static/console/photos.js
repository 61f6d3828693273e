/** Photos of a victim, a note or a tag: small ones in a row, one large when it is chosen, and leaving one. */

import { fetchChecked, missionPath, request } from "./api.js";
import { timeOfDay } from "./format.js";
import { newId } from "./note_kinds.js";
import { placeOf } from "./note_place.js";
import { Component, html } from "./vendor.js";

/** @import {Photo} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @typedef {{victim_id?: string, annotation_id?: string, tag_id?: string, x_m?: number, y_m?: number}} Subject */

const UPLOAD_MS = 60_000;
const KINDS = "image/jpeg,image/png,image/webp";

/** What a photo is of, as one word to group by. @param {Photo} photo */
const subjectOf = (photo) => photo.victim_id ? `victim/${photo.victim_id}`
  : photo.annotation_id ? `note/${photo.annotation_id}` : photo.tag_id ? `tag/${photo.tag_id}` : `at/${photo.x_m}/${photo.y_m}`;

/** Photos by what they are of, each with its place as far as that is known. @param {Store} store */
export function placedPhotos(store) {
  const { victims, tags } = store.shown;
  /** @type {Map<string, {photos: Photo[], x_m: number | null | undefined, y_m: number | null | undefined}>} */
  const groups = new Map();
  for (const photo of store.photos.values()) {
    const key = subjectOf(photo);
    const group = groups.get(key);
    if (group) {
      group.photos.push(photo);
      continue;
    }
    const note = store.annotations.get(photo.annotation_id ?? "");
    const [x_m, y_m] = note ? placeOf(note, tags.get(note.tag_id ?? "")) : [];
    const thing = victims.get(photo.victim_id ?? "") ?? tags.get(photo.tag_id ?? "");
    groups.set(key, { photos: [photo], x_m: photo.x_m ?? x_m ?? thing?.x_m, y_m: photo.y_m ?? y_m ?? thing?.y_m });
  }
  return groups;
}

/** @param {Store} store @param {Subject} of @param {File} file */
async function leave(store, of, file) {
  const words = new URLSearchParams({ photo_id: newId(), ...Object.fromEntries(Object.entries(of).map(([k, v]) => [k, String(v)])) });
  store.uploads += 1;
  store.changed();
  try {
    await fetchChecked(`/api/v1${missionPath(store.missionId ?? "")}/photos?${words}`, {
      method: "POST", body: file, headers: { "Content-Type": file.type || "application/octet-stream" },
      signal: AbortSignal.timeout(UPLOAD_MS),
    });
  } catch (error) {
    store.notify(`The photo was not kept. ${/** @type {Error} */ (error).message}`);
  }
  store.uploads -= 1;
  store.changed();
}

/** @param {{store: Store, of: Subject}} props */
export function Photos({ store, of }) {
  const [name, id] = Object.entries(of)[0];
  const found = [...store.photos.values()].filter((photo) => /** @type {any} */ (photo)[name] === id);
  /** @param {any} event */
  const add = (event) => {
    for (const file of event.currentTarget.files) leave(store, of, file);
    event.currentTarget.value = "";
  };
  if (store.isOver && found.length === 0) return null;
  return html`<div class="photos" role="group" aria-label="Photos">
    ${found.map((photo) => html`<button type="button" class="photo" key=${photo.photo_id} aria-label=${titleOf(photo)}
      onClick=${() => openPhoto(store, photo.photo_id)}><img src=${photo.thumbnail} alt="" loading="lazy"/></button>`)}
    ${!store.isOver && html`<label class="photo-add">${store.uploads ? "Sending…" : "Add photo"}
      <input type="file" class="unseen" accept=${KINDS} multiple disabled=${store.uploads > 0} onChange=${add}/></label>`}</div>`;
}

/** @param {Photo} photo */
const titleOf = (photo) => `Photo${photo.text && `: ${photo.text}`}, by ${photo.by} at ${timeOfDay(photo.taken_unix_s ?? photo.created_unix_s)}`;

/** @param {Store} store @param {string | null} id */
export function openPhoto(store, id) {
  store.photo = id;
  store.changed();
}

/** The chosen photo over everything; arrows lead to the others of the same thing. @extends {Component<{store: Store}, {broken: string}>} */
export class PhotoViewer extends Component {
  /** @type {HTMLDialogElement | null} */
  dialog = null;

  componentDidMount() {
    this.dialog?.showModal();
  }

  /** @param {Photo} photo */
  async remove(photo) {
    const { store } = this.props;
    try {
      await request("DELETE", `${missionPath(store.missionId ?? "")}/photos/${photo.photo_id}`);
      openPhoto(store, null);
    } catch (error) {
      store.notify(`Not removed. ${/** @type {Error} */ (error).message}`);
    }
  }

  /** @param {{store: Store}} props */
  render({ store }) {
    const photo = /** @type {Photo} */ (store.photos.get(store.photo ?? ""));
    const others = [...store.photos.values()].filter((other) => subjectOf(other) === subjectOf(photo));
    /** @param {number} steps */
    const go = (steps) => openPhoto(store, others[(others.indexOf(photo) + steps + others.length) % others.length].photo_id);
    /** @param {KeyboardEvent} event */
    const key = (event) => {
      if (event.key === "ArrowRight" || event.key === "ArrowLeft") go(event.key === "ArrowRight" ? 1 : -1);
      event.stopPropagation();
    };
    return html`<dialog class="viewer" aria-label=${titleOf(photo)} onKeyDown=${key}
        ref=${(/** @type {HTMLDialogElement} */ dialog) => (this.dialog = dialog)} onClose=${() => openPhoto(store, null)}>
      ${this.state.broken === photo.photo_id
        ? html`<p role="alert">The picture cannot be shown: the server does not answer, or the photo was taken away.</p>`
        : html`<img key=${photo.photo_id} src=${photo.address} width=${photo.width} height=${photo.height} alt=${photo.text || "Photo"}
            onError=${() => this.setState({ broken: photo.photo_id })}/>`}
      <footer><p>${photo.text && html`<b>${photo.text}</b> `}By ${photo.by} at ${timeOfDay(photo.taken_unix_s ?? photo.created_unix_s)}.</p>
        ${others.length > 1 && html`<button type="button" onClick=${() => go(-1)} aria-label="Photo before">‹</button>
          <span>${others.indexOf(photo) + 1} of ${others.length}</span>
          <button type="button" onClick=${() => go(1)} aria-label="Next photo">›</button>`}
        ${!store.isOver && store.may("operator") && html`<button type="button" onClick=${() => this.remove(photo)}>Remove</button>`}
        <button type="button" onClick=${() => this.dialog?.close()}>Close</button></footer></dialog>`;
  }
}
