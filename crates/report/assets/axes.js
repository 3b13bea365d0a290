// Colours, numbers and ticks of the interactive layer; the ticks are those of the SVG.

const MARGIN = 0.05;
const FEW_POINTS = 60;
const CHARACTER = 6.8;
const FONT = '11.5px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif';

// ---- Colours of the style sheet, read again when light turns to dark.

let colours = {};
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ink", "muted", "grid", "grid-minor", "paper", "band"];
  for (let k = 0; k < 8; k++) names.push("c" + k);
  for (const name of names) colours[name] = style.getPropertyValue("--" + name).trim();
}

// ---- Numbers.

const SUPERSCRIPT = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

function powerOfTen(exponent) {
  return "10" + Array.from(String(exponent), (c) => SUPERSCRIPT[c]).join("");
}

function minus(text) {
  return /^-0(\.0*)?$/.test(text) ? text.slice(1) : text.replace("-", "−");
}

// Five significant digits.
function readable(x) {
  if (!Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(x)));
  if (exponent >= -3 && exponent < 7) return minus(x.toFixed(Math.max(0, 4 - exponent)));
  return minus((x / 10 ** exponent).toFixed(3)) + "·" + powerOfTen(exponent);
}

function withUnit(x, unit) {
  return unit === "" ? readable(x) : readable(x) + (unit === "°" ? "" : "\u202f") + unit;
}

// ---- Curves: three letters a value, its place on a grid between two ends; the last code is a gap.

const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
const CODES = new Uint8Array(128);
Array.from(LETTERS).forEach((letter, code) => { CODES[letter.charCodeAt(0)] = code; });
const GAP = 2 ** 18 - 1;

function unpack(text, [low, high], axis) {
  const values = new Array(text.length / 3);
  for (let k = 0; k < values.length; k++) {
    const at = (i) => CODES[text.charCodeAt(3 * k + i)];
    const code = (at(0) << 12) | (at(1) << 6) | at(2);
    const part = code / (GAP - 1);
    const place = low * (1 - part) + high * part;
    values[k] = code === GAP ? null : axis.mapping === "log" ? Math.exp(place) : place;
  }
  return values;
}

function unpackAll(chart) {
  if (chart.shared) chart.shared = unpack(chart.shared, chart.ends, chart.x);
  for (const panel of chart.panels) {
    for (const trace of panel.traces) {
      if (trace.x) trace.x = unpack(trace.x, chart.ends, chart.x);
      trace.y = unpack(trace.y, trace.ends, panel.y);
    }
  }
  return chart;
}

// ---- Ticks, as in the SVG.

function roundStep(range, wanted) {
  const raw = range / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(raw));
  const ratio = raw / power;
  return power * (ratio < 1.001 ? 1 : ratio < 2.001 ? 2 : ratio < 5.001 ? 5 : 10);
}

function degreeStep(range, wanted) {
  if (range < wanted) return roundStep(range, wanted);
  const steps = [1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720, 1440];
  return steps.find((step) => range / step <= wanted + 1) || roundStep(range, wanted);
}

function evenTicks(low, high, step) {
  const values = [];
  if (!(step > 0 && Number.isFinite(step))) return values;
  const first = Math.ceil(low / step - 1e-9);
  for (let k = 0; k < 60; k++) {
    const value = (first + k) * step;
    if (value > high + 1e-9 * step) break;
    values.push(value);
  }
  return values;
}

function logTicks(low, high, wanted) {
  const from = Math.log10(low), to = Math.log10(high), decades = to - from;
  if (decades < 0.7) return evenTicks(low, high, roundStep(high - low, wanted));
  const multiples = decades < 2 ? [1, 2, 5] : [1];
  const stride = Math.max(1, Math.ceil(decades / Math.max(1, wanted)));
  const values = [];
  for (let k = Math.floor(from); k <= Math.ceil(to); k++) {
    if (k % stride !== 0) continue;
    for (const m of multiples) values.push(m * 10 ** k);
  }
  return values.filter((x) => x >= low * (1 - 1e-9) && x <= high * (1 + 1e-9));
}

function minorTicks(axis, low, high) {
  const decades = Math.log10(high / low);
  if (axis.mapping !== "log" || decades > 7 || decades < 0.7) return [];
  const values = [];
  for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k++) {
    for (let m = 2; m < 10; m++) values.push(m * 10 ** k);
  }
  return values.filter((x) => x >= low && x <= high);
}

function ticks(axis, low, high, pixels, spacing, most) {
  const wanted = Math.min(most, Math.max(3, Math.floor(pixels / spacing)));
  if (axis.mapping === "log") return logTicks(low, high, wanted);
  const step = axis.mapping === "degrees" ? degreeStep(high - low, wanted) : roundStep(high - low, wanted);
  return evenTicks(low, high, step);
}

// Labels without the axis' offset and power of ten, which stand in its heading.
function tickLabels(axis, values) {
  const unit = 10 ** axis.exponent;
  if (axis.mapping === "log" && (values.length < 2 || values[values.length - 1] / values[0] > 4.9)) {
    const plain = values.every((x) => x >= 9e-4 && x <= 2e5);
    return values.map((x) => {
      const exponent = Math.floor(Math.log10(x) + 1e-9);
      if (plain) return x.toFixed(Math.max(0, -exponent));
      const multiple = Math.round(x / 10 ** exponent);
      return (multiple > 1 ? multiple + "·" : "") + powerOfTen(exponent);
    });
  }
  const step = values.length > 1 ? values[1] - values[0] : axis.high - axis.low;
  const decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(step / unit) + 1e-9)));
  return values.map((x) => minus(((x - axis.offset) / unit).toFixed(decimals)));
}

// ---- Geometry.

function fraction(axis, x, low, high) {
  return axis.mapping === "log" ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low);
}

// A curve much longer than the plot is wide would not show its dashes.
function isDense(chart, panel, xs, ys, width, height) {
  let length = 0, px = NaN, py = NaN;
  for (let i = 0; i < ys.length; i++) {
    const x = ys[i] == null ? NaN : fraction(chart.x, xs[i], chart.x.low, chart.x.high) * width;
    const y = ys[i] == null ? NaN : fraction(panel.y, ys[i], panel.y.low, panel.y.high) * height;
    const step = Math.hypot(x - px, y - py);
    if (step > 0) length += step;
    px = x;
    py = y;
  }
  return length > 8 * width;
}

function clamp(x, low, high) {
  return Math.min(high, Math.max(low, x));
}

function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  return node;
}
