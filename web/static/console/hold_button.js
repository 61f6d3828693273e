/** A button that has to be held: too much hangs on it for a touch by mistake, and nobody should have to answer a question. */

import { Component, html } from "./vendor.js";

export const HOLD_MS = 600;

/**
 * Fires after being held, by pointer or by Space or Enter. A click without a press before it comes from assistive
 * technology, which cannot hold, and fires at once.
 */
export class HoldButton extends Component {
  /** @param {{label: any, name: string, kind?: string, how?: string, longer?: string, disabled?: boolean, onFire: () => void}} props
   *  `how` to press it, and what is said when that was too short */
  constructor(props) {
    super(props);
    this.props = props;
    this.timer = 0;
    this.pressed = false;
    this.state = { holding: false, hint: false };
  }

  componentWillUnmount() {
    clearTimeout(this.timer);
  }

  begin() {
    if (this.props.disabled || this.state.holding) return;
    this.pressed = true;
    this.setState({ holding: true, hint: false });
    this.timer = setTimeout(() => {
      this.setState({ holding: false });
      this.timer = 0;
      this.props.onFire();
    }, HOLD_MS);
  }

  end() {
    if (!this.state.holding) return;
    clearTimeout(this.timer);
    this.setState({ holding: false, hint: true });
    setTimeout(() => this.setState({ hint: false }), 2500);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault(); // or the browser clicks when the key is let go
    if (event.type === "keydown") this.begin();
    else this.end();
  }

  click() {
    if (!this.pressed) this.props.onFire();
    this.pressed = false;
  }

  render() {
    const { label, name, kind = "", how = "Press and hold", longer = "Press longer", disabled } = this.props;
    const { holding, hint } = this.state;
    return html`<button type="button" class=${`hold ${kind}`} data-holding=${holding ? "" : null} disabled=${disabled}
      aria-label=${name} title=${how} onPointerDown=${(/** @type {PointerEvent} */ event) => {
        if (event.button === 0) this.begin();
      }} onPointerUp=${() => this.end()} onPointerLeave=${() => this.end()} onPointerCancel=${() => this.end()}
      onKeyDown=${(/** @type {KeyboardEvent} */ event) => this.key(event)}
      onKeyUp=${(/** @type {KeyboardEvent} */ event) => this.key(event)} onBlur=${() => this.end()}
      onContextMenu=${(/** @type {Event} */ event) => event.preventDefault()} onClick=${() => this.click()}>
      <span>${hint ? longer : label}</span></button>`;
  }
}
