// What a live figure draws below and above its curves: bands, marks, rules and their labels.
const drawing = {
  drawBelow(u, panel) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = colours.band;
    ctx.globalAlpha = 0.13;
    for (const band of this.chart.bands) {
      const from = u.valToPos(Math.max(band.from, u.scales.x.min), "x", true);
      const to = u.valToPos(Math.min(band.to, u.scales.x.max), "x", true);
      if (to > from) ctx.fillRect(from, bbox.top, to - from, bbox.height);
    }
    ctx.globalAlpha = 1;
    ctx.strokeStyle = colours["grid-minor"];
    ctx.lineWidth = uPlot.pxRatio;
    ctx.beginPath();
    for (const x of minorTicks(this.chart.x, u.scales.x.min, u.scales.x.max)) {
      const at = Math.round(u.valToPos(x, "x", true));
      ctx.moveTo(at, bbox.top);
      ctx.lineTo(at, bbox.top + bbox.height);
    }
    for (const y of minorTicks(panel.y, u.scales.y.min, u.scales.y.max)) {
      const at = Math.round(u.valToPos(y, "y", true));
      ctx.moveTo(bbox.left, at);
      ctx.lineTo(bbox.left + bbox.width, at);
    }
    ctx.stroke();
    ctx.restore();
  },

  drawAbove(u, panel) {
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = ratio;
    ctx.strokeStyle = colours.muted;
    ctx.font = FONT.replace("11.5px", 11.5 * ratio + "px");
    const line = (x0, y0, x1, y1, dash) => {
      ctx.setLineDash(dash.map((d) => d * ratio));
      ctx.beginPath();
      ctx.moveTo(x0, y0);
      ctx.lineTo(x1, y1);
      ctx.stroke();
    };
    const right = bbox.left + bbox.width;
    for (const limit of panel.limits) {
      const y = Math.round(u.valToPos(limit.value, "y", true));
      line(bbox.left, y, right, y, [5, 3]);
      this.label(ctx, limit.label, right - 4 * ratio, y - bbox.top < 14 * ratio ? y + 13 * ratio : y - 4 * ratio, "right");
    }
    for (const marker of this.chart.markers) {
      const x = Math.round(u.valToPos(marker.at, "x", true));
      line(x, bbox.top, x, bbox.top + bbox.height, [1, 3]);
    }
    if (u === this.plots[0] || this.plots.length === 0) this.drawLabels(u, ctx, bbox, ratio);
    ctx.restore();
  },

  // Labels of bands and markers, each in the first row where it has room.
  drawLabels(u, ctx, bbox, ratio) {
    const placed = [];
    const { min, max } = u.scales.x;
    const bands = this.chart.bands.filter((band) => band.to > min && band.from < max);
    const marks = bands.map((band) => ({ at: Math.max(band.from, min), label: band.label }))
      .concat(this.chart.markers.filter((marker) => marker.at >= min && marker.at <= max));
    for (const { at, label } of marks) {
      const x = u.valToPos(at, "x", true);
      const width = ctx.measureText(label).width + 6 * ratio;
      const turned = x + width > bbox.left + bbox.width && x - width > bbox.left;
      const from = turned ? x - width : x;
      let row = 0;
      while (row < 5 && placed.some((p) => p.row === row && from < p.to && p.from < from + width)) row++;
      placed.push({ row, from, to: from + width });
      this.label(ctx, label, turned ? x - 4 * ratio : x + 4 * ratio, bbox.top + (13 + 14 * row) * ratio, turned ? "right" : "left");
    }
  },

  label(ctx, text, x, y, align) {
    ctx.setLineDash([]);
    ctx.textAlign = align;
    ctx.lineJoin = "round";
    ctx.strokeStyle = colours.paper;
    ctx.lineWidth = 3 * uPlot.pxRatio;
    ctx.strokeText(text, x, y);
    ctx.fillStyle = colours.muted;
    ctx.fillText(text, x, y);
    ctx.strokeStyle = colours.muted;
    ctx.lineWidth = uPlot.pxRatio;
  },
};
