// Draws every figure that carries its numbers (chart_data.cpp writes them); without scripts the page keeps its tables.
"use strict";
(function () {
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;

  // Of a series its x and y, and where samples are all there: [first, last) of runs that are evenly spaced.
  function unpack(series) {
    const codes = new Int16Array(bytes(series.y)), y = new Array(series.n);
    for (let i = 0; i < series.n; ++i) y[i] = codes[i] === -32768 ? null : series.middle + series.step * codes[i];
    if (typeof series.x === "string") return { x: Array.from(new Float32Array(bytes(series.x))), y, even: [] };
    const x = [], even = [];
    for (const [length, first, step, is_thinned] of series.x) {
      if (series.band_limited && !is_thinned) even.push([x.length, x.length + length]);
      for (let i = 0; i < length; ++i) x.push(first + step * i);
    }
    return { x, y, even };
  }

  const ascends = x => x.every((value, i) => i === 0 || value > x[i - 1]);
  const is_same = (one, other) => one.length === other.length && one.every((value, i) => value === other[i]);

  function sorted({ x, y }) {
    const order = x.map((_, i) => i).filter(i => Number.isFinite(x[i])).sort((i, k) => x[i] - x[k]);
    return { x: order.map(i => x[i]), y: order.map(i => y[i]), even: [] };
  }

  // One column of x for all, rising, with a place for every point; undefined is where a series has none.
  function columns(all) {
    if (all.every(one => is_same(one.x, all[0].x))) return [all[0].x, ...all.map(one => one.y)];
    const points = [];
    all.forEach((one, k) => one.x.forEach((x, i) => points.push([x, k, one.y[i]])));
    points.sort((one, other) => one[0] - other[0]);
    const data = [[], ...all.map(() => [])];
    for (const [x, k, y] of points) {
      const last = data[0].length - 1;
      const row = last >= 0 && data[0][last] === x && data[k + 1][last] === undefined ? last : last + 1;
      data[0][row] = x;
      for (let c = 1; c < data.length; ++c) if (row > last) data[c][row] = undefined;
      data[k + 1][row] = y;
    }
    return data;
  }

  // A line through points [first, last]. Between evenly spaced samples of what is limited to their band it is the sum
  // of their neighbours, each times a sinc under a Lanczos window; straight elsewhere, and where nobody could see it.
  function trace({ x, y, even }, first, last, place, per_px, line) {
    const reach = 8, near_px = 3, sinc = t => (t === 0 ? 1 : Math.sin(Math.PI * t) / (Math.PI * t));
    let down = false;
    for (let i = Math.max(0, first - 1); i <= Math.min(last + 1, x.length - 1); ++i) {
      if (y[i] === undefined) continue;
      if (y[i] === null) {
        down = false;
        continue;
      }
      const [px, py] = place(x[i], y[i]);
      down ? line.lineTo(px, py) : line.moveTo(px, py);
      down = true;
      const from = i - reach + 1, to = i + reach, width = i + 1 < x.length ? (place(x[i + 1], y[i])[0] - px) / per_px : 0;
      if (!(width > near_px) || !even.some(([begin, end]) => begin <= from && to < end)) continue;
      if (y.slice(from, to + 1).some(value => value == null)) continue;
      const pieces = Math.ceil(width / 2);
      for (let k = 1; k < pieces; ++k) {
        let sum = 0, weights = 0;
        for (let j = from; j <= to; ++j) {
          const t = i + k / pieces - j, weight = sinc(t) * sinc(t / reach);
          sum += weight * y[j], weights += weight;
        }
        line.lineTo(...place(x[i] + (x[i + 1] - x[i]) * k / pieces, sum / weights));
      }
    }
    return line;
  }

  const curve = one => (u, series, first, last) => ({
    stroke: trace(one, first, last, (x, y) => [u.valToPos(x, "x", true), u.valToPos(y, "y", true)], devicePixelRatio, new Path2D()),
  });

  function within(u, act) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    act(ctx, bbox);
    ctx.restore();
  }

  const shade = spans => u => within(u, (ctx, bbox) => {
    const room = 4 * devicePixelRatio;
    ctx.font = 12 * devicePixelRatio + "px sans-serif";
    ctx.textBaseline = "top";
    for (const span of spans) {
      const from = Math.max(bbox.left, u.valToPos(span.from, "x", true));
      const to = Math.min(bbox.left + bbox.width, u.valToPos(span.to, "x", true));
      if (to <= from) continue;
      ctx.globalAlpha = 0.2;
      ctx.fillStyle = colour(span.colour);
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
      ctx.globalAlpha = 1;
      ctx.fillStyle = colour("ink");
      if (ctx.measureText(span.label).width + 2 * room < to - from) ctx.fillText(span.label, from + room, bbox.top + room);
    }
  });

  // Lines whose x turns back, loops, in the order of their points.
  const loops = (all, chart) => u => within(u, ctx => {
    all.forEach(({ x, y }, k) => {
      if (chart.series[k].points || ascends(x) || !u.series[k + 1].show) return;
      ctx.beginPath();
      x.forEach((at, i) => y[i] == null || ctx.lineTo(u.valToPos(at, "x", true), u.valToPos(y[i], "y", true)));
      ctx.strokeStyle = colour(chart.series[k].colour);
      ctx.lineWidth = 1.3 * devicePixelRatio;
      ctx.stroke();
    });
  });

  function digits(value, most = 4) {
    if (value == null) return "";
    const rounded = Number(value.toPrecision(most)), size = Math.abs(rounded);
    return size > 0 && (size < 1e-3 || size >= 1e6) ? rounded.toExponential().replace("e+", "e") : rounded.toString();
  }
  const place_digits = 8;  // of an abscissa: milliseconds of a day
  const charts = [];       // {plot, chart, group, low, high}

  // Measured lies broad and grey under identified.
  const is_under = (chart, one) => one.label === "measured" && chart.series.some(other => other.dashed);
  const pen_of = (chart, one) => colour(is_under(chart, one) ? "under" : one.colour);

  function style_of(chart, one, values, is_loop) {
    const pen = () => pen_of(chart, one);
    const style = { label: one.label, stroke: pen, width: one.dashed ? 1.8 : is_under(chart, one) ? 3.5 : 1.3,
                    dash: one.dashed ? [7, 4] : undefined, spanGaps: false, points: { show: one.n < 60 },
                    value: (u, v) => digits(v) };
    if (one.points)
      Object.assign(style, { paths: () => null, points: { show: true, size: one.n < 200 ? 6 : 3, width: 0, fill: pen, stroke: pen } });
    else if (is_loop)
      Object.assign(style, { paths: () => null, points: { show: false } });
    else if (values.even.length > 0)
      style.paths = curve(values);
    return style;
  }

  function draw_panel(place, chart, number, is_last, group) {
    const falls = ({ x }) => x.length > 1 && ascends(x.slice().reverse());
    const all = chart.series.map(unpack).map(one => (falls(one) ? sorted(one) : one));
    if (all.length === 0) return null;
    const is_shared = all.every(one => is_same(one.x, all[0].x));
    const data = columns(all.map(one => (ascends(one.x) ? one : sorted(one))));
    const axis = label => ({ label: label, stroke: () => colour("ink"), grid: { stroke: () => colour("line"), width: 0.5 },
                             ticks: { stroke: () => colour("line") }, labelSize: label ? 22 : 0, labelFont: "13px sans-serif" });
    const height = () => Math.round(number > 0 ? 180 : Math.min(340, Math.max(230, 0.42 * place.clientWidth)));
    const one = { chart, group, all, is_shared, is_limited: true };
    const options = {
      width: place.clientWidth, height: height(),
      scales: { x: Object.assign({ time: false }, chart.x_log ? { distr: 3, range: (u, low, high) => [low, high] } : {}),
                y: chart.y_view ? { range: (u, low, high) => (one.is_limited ? chart.y_view : uPlot.rangeNum(low, high, 0.1, true)) } : {} },
      axes: [Object.assign(axis(is_last ? chart.x_label : ""), { values: (u, ticks) => ticks.map(v => digits(v, place_digits)) },
                           chart.x_log ? { splits: (u, i, low, high) => log_ticks(low, high) } : {}),
             Object.assign(axis(chart.y_label), { size: 62, space: number > 0 ? 20 : 30, values: (u, ticks) => ticks.map(v => digits(v)) })],
      series: [{ label: chart.x_label, value: (u, v) => digits(v, place_digits) }].concat(chart.series.map((one, k) =>
        Object.assign(style_of(chart, one, is_shared ? all[k] : { even: [] }, !ascends(all[k].x)),
                      { label: one.label || (chart.series.length > 1 ? "interval" : chart.y_label) }))),
      hooks: { drawClear: [shade(chart.spans)], draw: [loops(all, chart)], setSelect: [] },
      legend: { markers: { width: 2, dash: (u, i) => (i > 0 && chart.series[i - 1].dashed ? "dashed" : "solid") } },
      cursor: { drag: { x: true, y: false, setScale: false }, sync: group ? { key: group } : undefined },
    };
    Object.assign(one, { low: data[0][0], high: data[0][data[0].length - 1] });
    options.hooks.setSelect.push(u => {
      if (u.select.width < 2) return;
      const from = u.posToVal(u.select.left, "x"), to = u.posToVal(u.select.left + u.select.width, "x");
      u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
      show(one, from, to);
    });
    one.plot = new uPlot(options, data, place);
    if (chart.view) one.plot.setScale("x", { min: chart.view[0], max: chart.view[1] });
    charts.push(one);
    new ResizeObserver(() => {
      if (place.clientWidth > 0 && place.clientWidth !== one.plot.width)
        one.plot.setSize({ width: place.clientWidth, height: height() });
    }).observe(place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => one.plot.redraw());
    return one;
  }

  // Charts of one record have one time axis.
  function show(one, min, max) {
    for (const other of charts) {
      if (other !== one && other.group !== one.group) continue;
      other.is_limited = false;
      other.plot.setScale("x", { min, max });
    }
  }

  // What lies on one clock: a range, a recording, a part of a record of several bodies.
  function group_of(figure) {
    const name = figure.getAttribute("aria-labelledby"), found = /^figure-(range-\d+|recording-\d+)/.exec(name);
    const part = /^figure-(?:body-\d+-free-run|record-\d+)(-\d+)?$/.exec(name);
    return found ? found[1] : part ? "part" + (part[1] || "") : name;
  }

  function add_button(tools, name, act, title) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    if (title) button.title = title;
    button.addEventListener("click", act);
    tools.appendChild(button);
  }

  function save(name, blob) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  const cell = value => (value == null ? "" : String(value)), quoted = text => '"' + text.replace(/"/g, '""') + '"';

  function csv(panels) {
    const heads = [panels[0].chart.x_label], tables = [];
    for (const { chart, plot } of panels) {
      heads.push(...chart.series.map(one => one.label || chart.y_label));
      plot.data.slice(1).forEach(y => tables.push({ x: plot.data[0], y }));
    }
    const data = columns(tables), rows = [heads.map(quoted).join(",")];
    data[0].forEach((_, i) => rows.push(data.map(column => cell(column[i])).join(",")));
    return new Blob([rows.join("\n") + "\n"], { type: "text/csv" });
  }

  function png(panels, then) {
    const ratio = devicePixelRatio, head = 20 * ratio, picture = document.createElement("canvas"), ctx = picture.getContext("2d");
    picture.width = Math.max(...panels.map(one => one.plot.ctx.canvas.width));
    picture.height = panels.reduce((sum, one) => sum + head + one.plot.ctx.canvas.height, 0);
    ctx.fillStyle = colour("paper");
    ctx.fillRect(0, 0, picture.width, picture.height);
    ctx.font = 12 * ratio + "px sans-serif";
    let top = 0;
    for (const { plot, chart } of panels) {
      let left = plot.bbox.left;
      chart.series.forEach((one, k) => {
        if (!one.label || !plot.series[k + 1].show) return;
        ctx.fillStyle = pen_of(chart, one);
        ctx.fillText(one.label, left, top + 14 * ratio);
        left += ctx.measureText(one.label).width + 16 * ratio;
      });
      ctx.drawImage(plot.ctx.canvas, 0, top + head);
      top += head + plot.ctx.canvas.height;
    }
    picture.toBlob(then, "image/png");
  }

  const escaped = text => text.replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

  function ticks(low, high) {
    const rough = (high - low) / 6, decade = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = [1, 2, 5, 10].map(one => one * decade).find(one => one >= rough), found = [];
    for (let n = Math.ceil(low / step); n * step <= high; ++n) found.push(n * step);
    return found;
  }

  // To where x is even on its axis, and back.
  const scales_of = chart => (chart.x_log ? [Math.log, Math.exp] : [x => x, x => x]);

  // 1, 2 and 5 times the powers of ten, or these alone.
  function log_ticks(low, high) {
    const first = Math.floor(Math.log10(low)), last = Math.log10(high), found = [];
    for (let power = first; power <= last; ++power)
      for (const factor of last - first > 3 ? [1] : [1, 2, 5]) found.push(factor * Math.pow(10, power));
    const inside = found.filter(one => one >= low && one <= high);
    return inside.length > 1 ? inside : ticks(low, high);
  }

  const on_paper = { ink: "#1a1a1a", under: "#a6a6a6", vermilion: "#d55e00", blue: "#0072b2", green: "#009e73",
                     orange: "#e69f00", purple: "#cc79a7", sky: "#56b4e9" };

  // What is shown, as lines and points of a drawing.
  function svg(panels) {
    const width = 900, heights = panels.map((_, i) => (i > 0 ? 180 : 340)), parts = [];
    let top = 0;
    panels.forEach(({ chart, plot, all }, number) => {
      const left = 80, right = width - 15, upper = top + 24, lower = top + heights[number] - 44;
      const { x: xs, y: ys } = plot.scales, flat = one => one.toFixed(2);
      const [scaled] = scales_of(chart);
      const at = x => left + (right - left) * (scaled(x) - scaled(xs.min)) / (scaled(xs.max) - scaled(xs.min));
      const up = y => lower - (lower - upper) * (y - ys.min) / (ys.max - ys.min);
      const text = (x, y, anchor, words, more = "") =>
        parts.push(`<text x="${flat(x)}" y="${flat(y)}" text-anchor="${anchor}"${more}>${escaped(words)}</text>`);
      parts.push(`<clipPath id="c${number}"><path d="M${left} ${upper}H${right}V${lower}H${left}Z"/></clipPath>`);
      for (const span of chart.spans)
        parts.push(`<path d="M${flat(at(span.from))} ${upper}H${flat(at(span.to))}V${lower}H${flat(at(span.from))}Z" ` +
                   `fill="${on_paper[span.colour]}" fill-opacity="0.2" clip-path="url(#c${number})"/>`);
      for (const one of (chart.x_log ? log_ticks : ticks)(xs.min, xs.max)) {
        parts.push(`<path d="M${flat(at(one))} ${upper}V${lower}" stroke="#ddd"/>`);
        text(at(one), lower + 16, "middle", digits(one, place_digits));
      }
      for (const one of ticks(ys.min, ys.max)) {
        parts.push(`<path d="M${left} ${flat(up(one))}H${right}" stroke="#ddd"/>`);
        text(left - 6, up(one) + 4, "end", digits(one));
      }
      parts.push(`<path d="M${left} ${upper}H${right}V${lower}H${left}Z" fill="none" stroke="#444"/>`);
      text((left + right) / 2, lower + 36, "middle", chart.x_label);
      text(18, (upper + lower) / 2, "middle", chart.y_label, ` transform="rotate(-90 18 ${flat((upper + lower) / 2)})"`);
      let legend = left + 10;
      chart.series.forEach((one, k) => {
        if (!plot.series[k + 1].show) return;
        const { x, y } = all[k], broad = is_under(chart, one), ink = on_paper[broad ? "under" : one.colour];
        const first = ascends(x) ? x.findIndex(place => place >= xs.min) : 0;
        const beyond = ascends(x) ? x.findIndex(place => place > xs.max) : -1;
        const last = beyond < 0 ? x.length - 1 : beyond;
        let path = "";
        const line = { moveTo: (px, py) => (path += `M${flat(px)} ${flat(py)}`), lineTo: (px, py) => (path += `L${flat(px)} ${flat(py)}`) };
        if (one.points)
          x.forEach((place, i) => place >= xs.min && place <= xs.max && y[i] != null && (path += `M${flat(at(place))} ${flat(up(y[i]))}h0`));
        else if (first >= 0)
          trace(all[k], first, last, (px, py) => [at(px), up(py)], 1, line);
        const pen = one.points ? 'stroke-width="4" stroke-linecap="round"'
                  : one.dashed ? 'stroke-width="1.6" stroke-dasharray="6 4"' : `stroke-width="${broad ? 3.5 : 1.3}"`;
        parts.push(`<path d="${path}" fill="none" stroke="${ink}" ${pen} clip-path="url(#c${number})"/>`);
        if (!one.label) return;
        text(legend, upper - 8, "start", one.label, ` fill="${ink}"`);
        legend += 7 * one.label.length + 24;
      });
      top += heights[number];
    });
    return new Blob([`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${top}" viewBox="0 0 ${width} ${top}" ` +
                     `font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>${parts.join("\n")}</svg>`],
                    { type: "image/svg+xml" });
  }

  function draw(figure) {
    const group = group_of(figure), tools = figure.querySelector(".tools"), name = tools.dataset.name;
    const panels = Array.from(figure.querySelectorAll(".plot")).map((place, number, { length }) => {
      const chart = JSON.parse(place.querySelector("script").textContent);
      return draw_panel(place, chart, number, number === length - 1, chart.x_label.startsWith("time") ? group : figure.getAttribute("aria-labelledby"));
    }).filter(one => one);
    if (panels.length === 0) return;
    const first = panels[0], timed = first.chart.x_label.startsWith("time");
    const [scaled, unscaled] = scales_of(first.chart);
    const move = (shift, factor) => {
      const [min, max, low, high] = [first.plot.scales.x.min, first.plot.scales.x.max, first.low, first.high].map(scaled);
      const width = Math.min((max - min) * factor, high - low), from = 0.5 * (min + max) + shift * (max - min) - 0.5 * width;
      const begin = Math.max(low, Math.min(high - width, from));
      show(first, unscaled(begin), unscaled(begin + width));
    };
    add_button(tools, "zoom in", () => move(0, 0.5));
    add_button(tools, "zoom out", () => move(0, 2));
    add_button(tools, timed ? "earlier" : "left", () => move(-0.4, 1));
    add_button(tools, timed ? "later" : "right", () => move(0.4, 1));
    add_button(tools, "all", () => show(first, first.low, first.high));
    add_button(tools, "SVG", () => save(name + ".svg", svg(panels)), "save what is shown as a drawing");
    add_button(tools, "PNG", () => png(panels, blob => save(name + ".png", blob)), "save what is shown as a picture");
    add_button(tools, "CSV", () => save(name + ".csv", csv(panels)), "save the numbers that the page has: to a part in 65 000 of their range, and thinned where they are many");
  }

  // A drawing without axes to zoom is saved as it is.
  function keep(figure) {
    const tools = figure.querySelector(".tools"), drawing = figure.querySelector("svg");
    if (!tools || !drawing) return;
    const blob = () => new Blob([new XMLSerializer().serializeToString(drawing)], { type: "image/svg+xml" });
    add_button(tools, "SVG", () => save(tools.dataset.name + ".svg", blob()), "save the drawing");
  }

  function copy(text, button) {
    const said = () => {
      button.textContent = "copied";
      setTimeout(() => (button.textContent = "copy"), 1500);
    };
    const by_hand = () => {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.appendChild(area);
      area.select();
      if (document.execCommand("copy")) said();
      area.remove();
    };
    navigator.clipboard ? navigator.clipboard.writeText(text).then(said, by_hand) : by_hand();
  }
  for (const block of document.querySelectorAll("pre.copied")) {
    const tools = document.createElement("div"), text = block.textContent;
    tools.className = "tools";
    add_button(tools, "copy", event => copy(text, event.target));
    block.after(tools);
  }

  // Figures that are folded away are drawn when they are unfolded.
  const is_seen = figure => !figure.closest("details:not([open])"), waiting = new Set(document.querySelectorAll("figure.chart"));
  let begun = false;
  function draw_one() {
    const figure = Array.from(waiting).find(is_seen);
    if (!figure) return false;
    waiting.delete(figure);
    try {
      draw(figure);
    } catch (error) {
      console.error(error);  // the others are drawn
    }
    return true;
  }
  function next() {
    begun = false;
    draw_one() ? begin() : (document.documentElement.dataset.drawn = "all");
  }
  function begin() {
    if (begun) return;
    begun = true;
    delete document.documentElement.dataset.drawn;
    setTimeout(next, 0);
  }
  document.querySelectorAll("figure.drawing").forEach(keep);
  document.addEventListener("toggle", begin, true);
  addEventListener("beforeprint", () => {
    while (draw_one());
  });
  begin();
})();
