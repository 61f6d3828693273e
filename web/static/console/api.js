/** Requests to the server, every failure as one sentence a person can act on. */

export class ApiError extends Error {
  /**
   * @param {string} code short name, as the server gives it
   * @param {string} message what is wrong and what to do
   * @param {number} status HTTP status, 0 when nothing came back
   */
  constructor(code, message, status) {
    super(message);
    this.code = code;
    this.status = status;
  }
}

const TIMEOUT_MS = 5000;
const ALWAYS = /\/(stop|session|evacuation(\/acknowledge)?)$/;
/** Why nothing may be changed now, in a sentence; empty while it may. */
export const refusal = { of: () => "" };

/**
 * @param {string} method
 * @param {string} path address under /api/v1
 * @param {unknown} [body] sent as JSON
 * @returns {Promise<any>} the answer's JSON
 */
export async function request(method, path, body) {
  if (method !== "GET" && refusal.of() && !ALWAYS.test(path)) throw new ApiError("in_the_past", refusal.of(), 0);
  const response = await fetchChecked(`/api/v1${path}`, {
    method,
    headers: body === undefined ? {} : { "Content-Type": "application/json" },
    body: body === undefined ? undefined : JSON.stringify(body),
  });
  if (response.status === 204) return null;
  try {
    return await response.json();
  } catch (error) {
    throw error instanceof SyntaxError
      ? new ApiError("bad_answer", "The server's answer could not be read. Reload the page.", response.status)
      : new ApiError("unreachable", "The server does not answer.", 0); // its answer broke off half-way
  }
}

/**
 * @param {string} address
 * @param {RequestInit} [options]
 * @returns {Promise<Response>} an answer with a good status
 */
export async function fetchChecked(address, options = {}) {
  let response;
  try {
    response = await fetch(address, { ...options, signal: options.signal ?? AbortSignal.timeout(TIMEOUT_MS) });
  } catch {
    throw new ApiError("unreachable", "The server does not answer.", 0);
  }
  if (response.ok) return response;
  if (response.status === 401 && !["/login", "/join"].includes(location.pathname)) {
    location.assign(`/login?next=${encodeURIComponent(location.pathname + location.search)}`);
  }
  let error = null;
  try {
    error = (await response.json()).error;
  } catch {
    // The body is no error of ours: the status has to do.
  }
  throw new ApiError(
    String(error?.code ?? "failed"),
    String(error?.message ?? `The server answered ${response.status}.`),
    response.status,
  );
}

/** @param {string} missionId */
export const missionPath = (missionId) => `/missions/${encodeURIComponent(missionId)}`;
