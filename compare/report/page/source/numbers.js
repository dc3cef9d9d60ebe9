const superscript = (n) => String(n).replace(/[-0-9]/g, (c) => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]);

// A number for people: three significant digits unless told otherwise, powers of ten where they are shorter.
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

export function percent(x) {
  if (typeof x !== "number") return x === "inf" ? "∞" : "–";
  const p = 100 * x;
  return `${p >= 1000 ? short(p, 2) : Number(p.toPrecision(p >= 100 ? 3 : p < .1 ? 1 : 2))} %`;
}

export function degrees(theta) { return `${Number(theta.toFixed(2))}°`; }

export function thetaOf(mu) { return Math.acos(Math.max(-1, Math.min(1, mu))) * 180 / Math.PI; }

export const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;

// float32, little-endian, in base64
export function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}
