const superscript = (n) => String(n).replace(/[-0-9]/g, (c) => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]);

// A number for people: three significant digits unless told otherwise, powers of ten where they are
// shorter.
export function short(x, digits = 3) {
  if (x === null || x === undefined) return "–";
  if (typeof x !== "number") return x === "inf" ? "∞" : String(x);
  if (!Number.isFinite(x)) return x > 0 ? "∞" : x < 0 ? "−∞" : "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e5 || size < 1e-3) {
    const exponent = Math.floor(Math.log10(size) + 1e-12);
    const mantissa = Number((x / 10 ** exponent).toPrecision(Math.min(digits, 2)));
    if (Math.abs(mantissa) === 10) return short(Math.sign(x) * 10 ** (exponent + 1), digits);
    return (Math.abs(mantissa) === 1 ? (mantissa < 0 ? "−" : "") : `${mantissa}·`.replace("-", "−")) +
      `10${superscript(exponent)}`;
  }
  return String(Number(x.toPrecision(digits))).replace("-", "−");
}

// A share as percent with two significant digits, never as a power of ten: as percent_text of the
// program (compare/request/percent.h).
export function percent(x) {
  if (typeof x !== "number" || Number.isNaN(x)) return x === "inf" ? "∞" : "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  const p = 100 * x, size = Math.abs(p), sign = p < 0 ? "−" : "";
  if (size > 1e6) return p > 0 ? "above 1000000 %" : "below −1000000 %";
  if (size > 0 && size < 1e-8) return p > 0 ? "below 0.00000001 %" : "above −0.00000001 %";
  if (size === 0) return "0 %";
  const exponent = Number(size.toExponential(1).split("e")[1]);
  return `${sign}${size.toFixed(Math.max(0, 1 - exponent))} %`;
}

// The one number that stands for a colour: its luminance, ITU-R BT.709-6 (phase/math/luminance.h).
// Errors combine in the same way where channels share walks.
export const luminanceWeights = [0.2126, 0.7152, 0.0722];
export const luminanceName = "luminance (Rec. 709)";
export const luminance = (list) => list.length === 1 ? list[0] : luminanceWeights.reduce((sum, w, c) => sum + w * list[c], 0);

export function degrees(theta) { return `${Number(theta.toFixed(2))}°`; }

export function thetaOf(mu) { return Math.acos(Math.max(-1, Math.min(1, mu))) * 180 / Math.PI; }

// float32, little-endian, in base64
export function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}
