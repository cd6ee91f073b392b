// Draws the diagrams that `view::Chart` describes, with uPlot.
"use strict";

const pylonCharts = (() => {
  const drawn = new Map();
  const probe = document.createElement("span");
  probe.hidden = true;
  document.body.append(probe);
  let known = {};

  // The style sheet's colour of that name in the present theme, light or dark.
  function colour(name) {
    if (!known[name]) {
      probe.style.color = `var(--${name})`;
      known[name] = getComputedStyle(probe).color;
    }
    return known[name];
  }

  function faint(name, alpha) {
    const parts = colour(name).match(/[\d.]+/g).slice(0, 3);
    return `rgba(${parts.join(", ")}, ${alpha})`;
  }

  const textSize = () => Math.round(parseFloat(getComputedStyle(document.documentElement).fontSize) * 0.76);
  const font = () => `${textSize()}px ${getComputedStyle(document.body).fontFamily}`;

  function number(value) {
    if (value == null) return "";
    const size = Math.abs(value);
    return value.toFixed(size >= 1000 ? 1 : size >= 10 ? 2 : 3);
  }

  function span(from, to) {
    return from === to ? number(from) : `${number(from)} to ${number(to)}`;
  }

  // uPlot's columns and series; every band is two series and the area between them.
  function layers(spec) {
    const columns = [spec.x];
    const named = new Map(spec.x_ticks);
    const series = [{ label: spec.x_name, value: (_, value) => named.get(value) ?? number(value) }];
    const bands = [];
    const roles = ["ink"];
    const add = (values, role, options) => {
      columns.push(values);
      roles.push(role);
      series.push({ spanGaps: true, points: { show: false }, value: (_, value) => number(value), ...options });
    };
    for (const band of spec.bands) {
      const dense = band.role === "residual";
      const edge = { stroke: () => faint(band.role, dense ? 0.9 : 0.35), width: dense ? 1 : 0.5 };
      // One entry in the legend, with both edges.
      const value = (_, __, ___, at) => at == null ? "" : span(band.from[at], band.to[at]);
      add(band.to, band.role, { label: band.name, ...edge, value });
      add(band.from, band.role, { label: band.name, ...edge, class: "edge" });
      const last = columns.length - 1;
      bands.push({ series: [last - 1, last], fill: () => faint(band.role, dense ? 0.55 : 0.22) });
    }
    for (const line of spec.lines) {
      const stroke = () => colour(line.role);
      if (line.dots) {
        const fill = () => faint(line.role, 0.55);
        add(line.y, line.role, { label: line.name, stroke, paths: () => null, points: { show: true, size: 4, width: 0, fill, stroke: fill } });
      } else if (line.knots) {
        add(line.y, line.role, { label: line.name, stroke, width: 2, points: { show: true, size: 9, fill: stroke, stroke } });
      } else {
        add(line.y, line.role, { label: line.name, stroke, width: line.role === "measured" ? 1 : 2 });
      }
    }
    return { columns, series, bands, roles };
  }

  function isWhole(plot, spec) {
    const { min, max } = plot.scales.x;
    const first = spec.x[0], last = spec.x[spec.x.length - 1];
    const slack = 0.002 * (last - first);
    return min == null || (min <= first + slack && max >= last - slack);
  }

  function yRange(plot, least, greatest, spec) {
    if (isWhole(plot, spec)) {
      if (spec.y_range) return spec.y_range;
      for (const level of spec.levels) {
        least = Math.min(least ?? level.y, level.y);
        greatest = Math.max(greatest ?? level.y, level.y);
      }
    }
    return least == null ? [-1, 1] : uPlot.rangeNum(least, greatest, 0.06, true);
  }

  // Draws only inside the diagram's axes.
  function clipped(plot, draw) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.font = font().replace(/^\d+/, (size) => size * devicePixelRatio);
    draw(ctx, bbox, devicePixelRatio);
    ctx.restore();
  }

  function shade(plot, spec) {
    clipped(plot, (ctx, bbox, ratio) => {
      for (const { name, from, to } of spec.shades) {
        const left = plot.valToPos(from, "x", true), right = plot.valToPos(to, "x", true);
        ctx.fillStyle = faint("shade", 0.22);
        ctx.fillRect(left, bbox.top, right - left, bbox.height);
        ctx.fillStyle = colour("shade");
        ctx.fillRect(left, bbox.top, right - left, 3 * ratio);
        if (ctx.measureText(name).width < right - left - 8 * ratio) {
          ctx.fillStyle = colour("ink");
          ctx.textAlign = "center";
          ctx.textBaseline = "top";
          ctx.fillText(name, (Math.max(left, bbox.left) + Math.min(right, bbox.left + bbox.width)) / 2, bbox.top + 7 * ratio);
        }
      }
    });
  }

  function mark(plot, spec) {
    clipped(plot, (ctx, bbox, ratio) => {
      ctx.lineWidth = 2 * ratio;
      ctx.textBaseline = "bottom";
      ctx.textAlign = "left";
      for (const { name, y, role } of spec.levels) {
        ctx.strokeStyle = colour(role);
        const at = plot.valToPos(y, "y", true);
        ctx.setLineDash([7 * ratio, 5 * ratio]);
        line(ctx, bbox.left, at, bbox.left + bbox.width, at);
        ctx.setLineDash([]);
        // Above its line, or below it if the diagram's edge would cut it off.
        const height = (textSize() + 3) * ratio;
        const base = at - 3 * ratio - height < bbox.top ? at + height : at - 3 * ratio;
        if (name) label(ctx, name, bbox.left + 6 * ratio, base, role, ratio);
      }
      spec.moments.forEach(({ name, x, role }, index) => {
        const at = plot.valToPos(x, "x", true);
        ctx.strokeStyle = colour(role);
        line(ctx, at, bbox.top, at, bbox.top + bbox.height);
        const room = bbox.left + bbox.width - at > ctx.measureText(name).width + 12 * ratio;
        ctx.textAlign = room ? "left" : "right";
        const below = bbox.top + bbox.height - (6 + index * 1.5 * textSize()) * ratio;
        label(ctx, name, at + (room ? 5 : -5) * ratio, below, role, ratio);
      });
    });
  }

  function line(ctx, x0, y0, x1, y1) {
    ctx.beginPath();
    ctx.moveTo(x0, y0);
    ctx.lineTo(x1, y1);
    ctx.stroke();
  }

  // Text outlined in the background colour, to be readable over anything.
  function label(ctx, text, x, y, role, ratio) {
    const { strokeStyle, lineWidth } = ctx;
    ctx.strokeStyle = colour("ground");
    ctx.lineWidth = 4 * ratio;
    ctx.lineJoin = "round";
    ctx.strokeText(text, x, y);
    ctx.fillStyle = colour(role);
    ctx.fillText(text, x, y);
    Object.assign(ctx, { strokeStyle, lineWidth });
  }

  function size(place) {
    const width = Math.max(place.clientWidth, 240);
    const small = place.classList.contains("small");
    return { width, height: small ? 210 : Math.round(Math.min(340, Math.max(220, width * 0.26))) };
  }

  function draw(place, spec) {
    const { columns, series, bands, roles } = layers(spec);
    const axis = { stroke: () => colour("ink"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("rule"), width: 1 }, font: font(), labelFont: font() };
    const named = spec.x_ticks.length > 0 && {
      splits: () => spec.x_ticks.map(([x]) => x),
      values: () => spec.x_ticks.map(([, name]) => name),
    };
    const plot = new uPlot({
      ...size(place),
      series,
      bands,
      scales: { x: { time: false }, y: { range: (self, least, greatest) => yRange(self, least, greatest, spec) } },
      axes: [
        { ...axis, ...named, label: spec.x_name, labelSize: textSize() * 1.7, size: textSize() * 2.4 },
        { ...axis, label: spec.y_name, labelSize: textSize() * 1.8, size: textSize() * 5 },
      ],
      cursor: { drag: { x: true, y: false, dist: 4 }, sync: spec.group ? { key: spec.group, setSeries: false } : undefined },
      legend: { markers: { width: 2, stroke: (_, index) => `var(--${roles[index]})`, fill: (_, index) => `color-mix(in srgb, var(--${roles[index]}) 45%, transparent)` } },
      hooks: {
        drawClear: [(self) => shade(self, spec)],
        draw: [(self) => mark(self, spec)],
        setScale: [(self, key) => key === "x" && place.classList.toggle("zoomed", !isWhole(self, spec))],
      },
    }, columns, place);
    place.plot = plot;
    drawn.set(place, { plot, spec });
    new ResizeObserver(() => {
      const now = size(place);
      if (now.width !== plot.width) plot.setSize(now);
    }).observe(place);
    return plot;
  }

  // Acts on all diagrams of a group, or on the one alone.
  function together(place, act) {
    const { spec } = drawn.get(place);
    for (const other of drawn.values()) {
      if (other.plot === place.plot || (spec.group && other.spec.group === spec.group)) act(other);
    }
  }

  function reset(place) {
    together(place, ({ plot, spec }) => plot.setScale("x", { min: spec.x[0], max: spec.x[spec.x.length - 1] }));
  }

  // Zooms about the cursor, or the middle; never further out than the data.
  function zoom(place, factor) {
    const { plot } = place;
    const { min, max } = plot.scales.x;
    const about = plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : (min + max) / 2;
    const from = about - (about - min) * factor, to = about + (max - about) * factor;
    together(place, (other) => {
      const { x } = other.spec;
      other.plot.setScale("x", { min: Math.max(from, x[0]), max: Math.min(to, x[x.length - 1]) });
    });
  }

  // Moves the cursor by a number of pixels; at the edge of a zoomed diagram, moves the diagram.
  function move(place, pixels) {
    const { plot } = place;
    const width = plot.over.clientWidth;
    const left = plot.cursor.left >= 0 ? plot.cursor.left + pixels : width / 2;
    if (left < 0 || left > width) {
      const { min, max } = plot.scales.x;
      const { x } = drawn.get(place).spec;
      const step = Math.sign(pixels) * 0.25 * (max - min);
      const shift = step < 0 ? Math.max(step, x[0] - min) : Math.min(step, x[x.length - 1] - max);
      together(place, (other) => other.plot.setScale("x", { min: min + shift, max: max + shift }));
    }
    plot.setCursor({ left: Math.min(Math.max(left, 0), width), top: plot.over.clientHeight / 2 });
  }

  function recolour() {
    known = {};
    for (const { plot } of drawn.values()) plot.redraw();
  }

  return { draw, drawn, reset, zoom, move, recolour };
})();
