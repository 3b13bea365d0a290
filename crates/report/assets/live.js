// The interactive layer: drag to zoom, point to read values, switch curves in the legend.
// Without it the page shows the same figures as SVG; print always does.

// ---- One figure.

class LiveFigure {
  constructor(figure, chart) {
    this.figure = figure;
    this.chart = unpackAll(chart);
    this.free = chart.kind === "free";
    this.plots = [];
    this.left = 34;
    this.hidden = new Set();
    this.full = { x: [chart.x.low, chart.x.high], y: [chart.panels[0].y.low, chart.panels[0].y.high] };
    this.x = this.full.x;
    this.y = this.full.y;
    this.build();
  }

  build() {
    const picture = Array.from(this.figure.querySelectorAll(".picture")).find((node) => node.offsetHeight > 0);
    const available = picture ? picture.offsetHeight : 300;
    const title = picture ? picture.querySelector("title").textContent + ". " + picture.querySelector("desc").textContent : "";
    this.live = element("div", "live");
    this.live.tabIndex = 0;
    this.live.setAttribute("role", "group");
    this.live.setAttribute("aria-label", title + " Arrow keys move the read-out, plus and minus zoom, Escape shows all.");
    const tools = element("div", "tools");
    this.xRead = element("span", "x-read");
    this.hint = element("span", "hint");
    this.hint.hidden = true;
    if (this.chart.stretch > 1) this.hint.textContent = "drawn: least and largest of every " + this.chart.stretch + " samples";
    this.reset = element("button", "", "Show all");
    this.reset.type = "button";
    this.reset.hidden = true;
    this.reset.addEventListener("click", () => { this.showAll(); this.live.focus(); });
    tools.append(this.hint, this.xRead, this.reset);
    this.announce = element("span", "visually-hidden");
    this.announce.setAttribute("aria-live", "polite");
    this.live.append(tools, this.announce);
    this.figure.querySelector(".plot").append(this.live);
    this.figure.classList.add("enhanced");

    const weights = this.chart.panels.reduce((sum, panel) => sum + panel.weight, 0);
    const count = this.chart.panels.length;
    const room = available - count * 26 - 30 - 20;
    this.key = "sync-" + this.figure.id;
    this.boxes = this.chart.panels.map((panel, k) => {
      this.live.append(element("p", "panel-heading", panel.y.heading));
      const box = element("div", "canvas");
      this.live.append(box);
      const last = k === count - 1;
      return { box, last, height: Math.max(50, Math.round((room * panel.weight) / weights)) + (last ? 30 : 10) };
    });
    this.live.append(element("p", "x-heading", this.chart.x.heading));
    this.width = this.live.clientWidth;
    this.chart.panels.forEach((panel, k) => this.plots.push(this.plot(panel, this.boxes[k])));
    this.legend();
    this.live.addEventListener("keydown", (event) => this.key_down(event));
    new ResizeObserver(() => this.resize()).observe(this.live);
  }

  plot(panel, { box, last, height }) {
    const chart = this.chart;
    const data = this.data(panel);
    const plotHeight = height - (last ? 30 : 10);
    const series = panel.traces.map((trace, k) => {
      const entry = chart.entries[trace.entry];
      const [xs, ys] = this.curve(panel, k);
      const dense = isDense(chart, panel, xs, ys, this.width, plotHeight);
      const look = {
        label: entry.name,
        stroke: () => colours["c" + entry.colour],
        width: 1.4,
        dash: dense ? [] : entry.dash,
        spanGaps: false,
        points: { show: !this.free && ys.length <= FEW_POINTS, size: 5, stroke: () => colours["c" + entry.colour], fill: () => colours["c" + entry.colour] },
      };
      if (this.free) {
        look.facets = [{ scale: "x", auto: false }, { scale: "y", auto: false }];
        look.paths = freePath;
        look.cap = "round";
      }
      return look;
    });
    const axes = this.axes(panel, last);
    const options = {
      mode: this.free ? 2 : 1,
      width: this.width,
      height,
      padding: [6, 16, last ? 0 : 4, 0],
      legend: { show: false },
      focus: { alpha: 1 },
      scales: this.scales(panel),
      axes,
      series: [this.free ? {} : { scale: "x" }].concat(series),
      cursor: this.cursor(panel),
      hooks: {
        drawClear: [(u) => this.drawBelow(u, panel)],
        draw: [(u) => this.drawAbove(u, panel)],
        setSelect: [(u) => this.selected(u)],
        setCursor: [(u) => this.pointed(u)],
      },
    };
    return new uPlot(options, data, box);
  }

  curve(panel, k) {
    const trace = panel.traces[k];
    return [trace.x || this.chart.shared, trace.y];
  }

  data(panel) {
    if (this.free) return [null].concat(panel.traces.map((trace) => [trace.x, trace.y]));
    if (this.chart.shared) return [this.chart.shared].concat(panel.traces.map((trace) => trace.y));
    return uPlot.join(panel.traces.map((trace) => [trace.x, trace.y]));
  }

  scales(panel) {
    const distribution = (axis) => (axis.mapping === "log" ? 3 : 1);
    const fixed = panel.y.label === "coherence";
    return {
      x: { time: false, auto: false, distr: distribution(this.chart.x), range: () => this.shown(0) },
      y: {
        auto: !this.free,
        distr: distribution(panel.y),
        range: (u, low, high) => {
          if (this.free) return this.shown(1);
          if (fixed || this.x === this.full.x || low == null || high == null) return [panel.y.low, panel.y.high];
          if (panel.y.mapping === "log") {
            const room = high > low ? (high / low) ** MARGIN : 1.2;
            return [low / room, high * room];
          }
          const room = high > low ? (high - low) * MARGIN : Math.abs(high) * 0.1 || 1;
          return [low - room, high + room];
        },
      },
    };
  }

  // The range shown along an axis (0 across, 1 up); with equal scales one of them is widened.
  shown(axis) {
    const ranges = [this.x, this.y];
    if (!this.chart.equal) return ranges[axis];
    const pixels = [this.width - this.left - 16, this.boxes[0].height - 30];
    const perPixel = ranges.map(([low, high], k) => (high - low) / pixels[k]);
    const most = Math.max(...perPixel);
    const middle = (ranges[axis][0] + ranges[axis][1]) / 2, half = (most * pixels[axis]) / 2;
    return [middle - half, middle + half];
  }

  axes(panel, last) {
    const look = {
      stroke: () => colours.muted,
      font: FONT,
      grid: { stroke: () => colours.grid, width: 1 },
      ticks: { show: false },
      border: { show: true, stroke: () => colours.muted, width: 1 },
      gap: 6,
      // Without it a logarithmic axis would drop the labels between decades.
      filter: (u, values) => values,
    };
    const across = {
      scale: "x",
      size: last ? 24 : 0,
      splits: (u, index, low, high) => ticks(this.chart.x, low, high, u.over.clientWidth || this.width, 80, 10),
      values: (u, values) => (last ? tickLabels(this.chart.x, values) : values.map(() => "")),
    };
    const up = {
      scale: "y",
      side: 3,
      size: (u, values) => this.axisSize(values),
      splits: (u, index, low, high) => ticks(panel.y, low, high, u.over.clientHeight || 150, 32, 7),
      values: (u, values) => tickLabels(panel.y, values),
    };
    return [Object.assign({ side: 2 }, look, across), Object.assign({}, look, up)];
  }

  // All panels share the widest axis, so that their plots stand below one another.
  axisSize(labels) {
    const needed = (labels || []).reduce((size, label) => Math.max(size, label.length * CHARACTER + 12), 34);
    if (needed > this.left) {
      this.left = needed;
      queueMicrotask(() => this.plots.forEach((u) => u.redraw(false, true)));
    }
    return this.left;
  }

  cursor(panel) {
    const drag = { x: true, y: this.free, uni: this.free ? 12 : Infinity, dist: 4, setScale: false };
    if (this.free) return { drag, x: true, y: true, points: { show: false }, dataIdx: () => null };
    const nearest = (u, seriesIndex, index) => {
      // Curves with other x values than the one pointed at: their nearest point.
      const values = u.data[seriesIndex];
      if (values[index] !== undefined) return index;
      for (let d = 1; d < values.length; d++) {
        if (values[index - d] !== undefined) return index - d;
        if (values[index + d] !== undefined) return index + d;
      }
      return index;
    };
    const points = { size: 7, width: 1.5, stroke: () => colours.paper, fill: (u, k) => colours["c" + this.chart.entries[panel.traces[k - 1].entry].colour] };
    return {
      drag,
      y: false,
      points,
      dataIdx: (u, k, index) => (k === 0 || index == null ? index : nearest(u, k, index)),
      sync: { key: this.key, setSeries: false, scales: ["x", null] },
      bind: { dblclick: () => () => { this.showAll(); return null; } },
    };
  }

  // ---- Zoom.

  selected(u) {
    const { left, top, width, height } = u.select;
    if (width < 4 && height < 4) return;
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    // The panels hear of one gesture one after the other; the first one's range counts.
    if (this.zooming) return;
    this.zooming = true;
    setTimeout(() => { this.zooming = false; }, 0);
    const x = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
    if (this.free) {
      const y = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
      const whole = (a, b) => !(b > a);
      this.show(whole(...x) || width < 4 ? this.x : x, whole(...y) || height < 4 ? this.y : y);
    } else if (x[1] > x[0]) {
      this.show(x, this.y);
    }
  }

  show(x, y) {
    const inside = (range, full) => [Math.max(range[0], full[0]), Math.min(range[1], full[1])];
    this.x = inside(x, this.full.x);
    this.y = this.free ? inside(y, this.full.y) : y;
    this.apply();
  }

  showAll() {
    this.x = this.full.x;
    this.y = this.full.y;
    this.left = 34;
    this.apply();
  }

  apply() {
    const zoomed = this.x !== this.full.x || this.y !== this.full.y;
    this.reset.hidden = !zoomed;
    this.hint.hidden = !zoomed;
    for (const u of this.plots) {
      u.batch(() => {
        u.setScale("x", { min: this.x[0], max: this.x[1] });
        if (this.free) u.setScale("y", { min: this.y[0], max: this.y[1] });
      });
    }
  }

  zoomBy(factor) {
    const scaled = (range, axis) => {
      const log = axis.mapping === "log";
      const [low, high] = log ? range.map(Math.log) : range;
      const middle = (low + high) / 2, half = ((high - low) / 2) * factor;
      const next = [middle - half, middle + half];
      return log ? next.map(Math.exp) : next;
    };
    const x = scaled(this.x, this.chart.x);
    if (x[0] <= this.full.x[0] && x[1] >= this.full.x[1]) this.showAll();
    else this.show(x, this.free ? scaled(this.y, this.chart.panels[0].y) : this.y);
  }

  // ---- Read-out.

  pointed(u) {
    if (this.free) this.readNearest(u);
    else this.readColumn(u);
  }

  readColumn(u) {
    const index = u.cursor.idx;
    if (index == null || u.cursor.left < 0) {
      if (u === this.plots[0]) this.clearRead();
      return;
    }
    this.xRead.textContent = this.chart.x.label + " " + withUnit(u.data[0][index], this.chart.x.unit);
    const texts = new Map();
    this.chart.panels.forEach((panel, p) => {
      const plot = this.plots[p];
      if (!plot || plot.cursor.idxs == null) return;
      panel.traces.forEach((trace, k) => {
        const at = plot.cursor.idxs[k + 1];
        const value = at == null ? null : plot.data[k + 1][at];
        const text = value == null ? "–" : withUnit(value, panel.y.unit);
        texts.set(trace.entry, texts.has(trace.entry) ? texts.get(trace.entry) + ", " + text : text);
      });
    });
    texts.forEach((text, entry) => { this.reads[entry].textContent = this.hidden.has(entry) ? "" : text; });
  }

  readNearest(u) {
    const { left, top } = u.cursor;
    this.point = this.point || u.over.appendChild(element("div", "nearest"));
    const found = left < 0 ? null : this.nearest(u, left, top);
    if (!found) {
      this.point.hidden = true;
      this.clearRead();
      return;
    }
    this.showPoint(u, found);
  }

  nearest(u, left, top) {
    let best = null;
    this.chart.panels[0].traces.forEach((trace) => {
      if (this.hidden.has(trace.entry)) return;
      for (let i = 0; i < trace.x.length; i++) {
        if (trace.x[i] == null || trace.y[i] == null) continue;
        const distance = Math.hypot(u.valToPos(trace.x[i], "x") - left, u.valToPos(trace.y[i], "y") - top);
        if (!best || distance < best.distance) best = { trace, i, distance };
      }
    });
    return best;
  }

  showPoint(u, { trace, i }) {
    const panel = this.chart.panels[0];
    this.clearRead();
    this.point.hidden = false;
    this.point.style.left = u.valToPos(trace.x[i], "x") + "px";
    this.point.style.top = u.valToPos(trace.y[i], "y") + "px";
    this.point.style.background = colours["c" + this.chart.entries[trace.entry].colour];
    this.xRead.textContent = withUnit(trace.x[i], this.chart.x.unit) + " | " + withUnit(trace.y[i], panel.y.unit);
  }

  clearRead() {
    this.xRead.textContent = "";
    for (const read of this.reads || []) read.textContent = "";
  }

  // ---- Legend and keys.

  legend() {
    this.reads = [];
    this.figure.querySelectorAll(".legend li").forEach((item) => {
      const entry = Number(item.dataset.entry);
      const button = element("button");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.append(...item.childNodes);
      const read = element("span", "read");
      item.append(button);
      if (!this.free) item.append(read);
      this.reads[entry] = read;
      button.addEventListener("click", () => {
        const show = this.hidden.has(entry);
        if (show) this.hidden.delete(entry);
        else this.hidden.add(entry);
        button.setAttribute("aria-pressed", String(show));
        this.chart.panels.forEach((panel, p) => panel.traces.forEach((trace, k) => {
          if (trace.entry === entry) this.plots[p].setSeries(k + 1, { show });
        }));
      });
    });
  }

  key_down(event) {
    if (event.target !== this.live || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 20 : 1;
    const actions = {
      ArrowLeft: () => this.moveBy(-step),
      ArrowRight: () => this.moveBy(step),
      "+": () => this.zoomBy(0.5),
      "=": () => this.zoomBy(0.5),
      "-": () => this.zoomBy(2),
      Escape: () => this.showAll(),
      0: () => this.showAll(),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  moveBy(step) {
    const u = this.plots[0];
    if (this.free) {
      const trace = this.chart.panels[0].traces.find((candidate) => !this.hidden.has(candidate.entry));
      if (!trace) return;
      this.at = clamp((this.at ?? -1) + step, 0, trace.x.length - 1);
      this.point = this.point || u.over.appendChild(element("div", "nearest"));
      if (trace.x[this.at] != null && trace.y[this.at] != null) this.showPoint(u, { trace, i: this.at });
      this.announce.textContent = this.xRead.textContent;
      return;
    }
    const xs = u.data[0];
    // In pixels of the plot, so that one key press is a step that can be seen.
    const pixel = Math.max(1, u.over.clientWidth / 200);
    const left = u.cursor.left >= 0 ? u.cursor.left : 0;
    const target = clamp(left + step * pixel, 0, u.over.clientWidth - 1);
    const index = u.valToIdx(u.posToVal(target, "x"));
    const current = u.cursor.idx ?? 0;
    const next = index === current ? clamp(current + Math.sign(step), 0, xs.length - 1) : index;
    const position = index === current ? u.valToPos(xs[next], "x") : target;
    this.plots.forEach((plot) => plot.setCursor({ left: position, top: 5 }, true, false));
    this.announce.textContent = this.xRead.textContent + "; " + this.chart.entries
      .map((entry, k) => entry.name + " " + (this.reads[k].textContent || "hidden")).join("; ");
  }

  resize() {
    const width = this.live.clientWidth;
    if (width === 0 || width === this.width) return;
    this.width = width;
    this.plots.forEach((u, k) => u.setSize({ width, height: this.boxes[k].height }));
  }

  redraw() {
    this.plots.forEach((u) => u.redraw(false, true));
  }
}

Object.assign(LiveFigure.prototype, drawing);

// A line through points in their order, for curves whose x does not increase.
function freePath(u, seriesIndex) {
  const path = new Path2D();
  uPlot.orient(u, seriesIndex, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    let open = false;
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] == null || ys[i] == null) {
        open = false;
        continue;
      }
      const x = toX(xs[i], scaleX, width, left), y = toY(ys[i], scaleY, height, top);
      if (!open) path.moveTo(x, y);
      // A point between gaps becomes a dot: a line of no length with round ends.
      path.lineTo(x, y);
      open = true;
    }
  });
  return { stroke: path, fill: null, clip: null, band: null, gaps: null, flags: 0 };
}

// ---- Start: each figure when it comes into view.

function start() {
  readColours();
  const figures = [];
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((seen) => seen.isIntersecting)) {
      observer.unobserve(entry.target);
      const script = document.querySelector('script[data-chart="' + entry.target.id + '"]');
      figures.push(new LiveFigure(entry.target, JSON.parse(script.textContent)));
    }
  }, { rootMargin: "300px" });
  for (const script of document.querySelectorAll("script[data-chart]")) {
    observer.observe(document.getElementById(script.dataset.chart));
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readColours();
    figures.forEach((figure) => figure.redraw());
  });
}

if (window.uPlot && window.IntersectionObserver && window.ResizeObserver) start();
