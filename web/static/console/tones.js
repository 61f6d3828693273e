/** Signals that are heard: no two are alike. */

/**
 * Tones one after the other: hertz and seconds each, 0 Hz is a pause. EVACUATE is INSARAG's three short ones, MAYDAY
 * wails, an alert of another kind is one soft tone, an alarm two.
 * @type {Record<string, [number, number][]>}
 */
export const TONES = {
  evacuate: [[880, 0.5], [0, 0.25], [880, 0.5], [0, 0.25], [880, 0.5]],
  mayday: [[620, 0.35], [1240, 0.35], [620, 0.35], [1240, 0.35]],
  alarm: [[740, 0.16], [0, 0.08], [740, 0.16]],
  warning: [[440, 0.2]],
};
export const AGAIN_MS = 8000; // MAYDAY and EVACUATE sound until somebody has acknowledged them

/** @type {AudioContext | null} */
let audio = null;

/** A page may sound only once somebody has pressed something: to be called from there. */
export function allowSound() {
  audio ??= new AudioContext();
  audio.resume();
  return audio;
}

/** Nothing where nobody has pressed anything yet: else all of it would sound together at the first touch. @param {string} name */
export function sound(name) {
  if (navigator.userActivation?.hasBeenActive === false) return;
  const audio = allowSound();
  let at = audio.currentTime + 0.02;
  for (const [hertz, seconds] of TONES[name]) {
    if (hertz) {
      const tone = audio.createOscillator();
      const volume = audio.createGain();
      tone.frequency.value = hertz;
      volume.gain.setValueAtTime(0, at);
      volume.gain.linearRampToValueAtTime(0.25, at + 0.02);
      volume.gain.setValueAtTime(0.25, at + seconds - 0.03);
      volume.gain.linearRampToValueAtTime(0, at + seconds);
      tone.connect(volume).connect(audio.destination);
      tone.start(at);
      tone.stop(at + seconds);
    }
    at += seconds;
  }
}
