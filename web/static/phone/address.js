/** What an address of the phone's page names. */

/** A link that was damaged on its way names a tag that nobody knows, and so is told. @param {string} text */
function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** The tag and mission that an address of this page names. */
export function here(address = new URL(location.href)) {
  const [, first, tag] = address.pathname.split("/");
  return /** @type {const} */ ([first === "t" ? decoded(tag ?? "") : "", address.searchParams.get("mission")]);
}
