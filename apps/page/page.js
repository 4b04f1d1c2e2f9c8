// Draws every figure that carries its numbers (chart_data.cpp writes them); without scripts the page keeps its tables.
"use strict";
(function () {
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;

  function unpack(series) {
    const codes = new Int16Array(bytes(series.y)), y = new Array(series.n);
    for (let i = 0; i < series.n; ++i) y[i] = codes[i] === -32768 ? null : series.middle + series.step * codes[i];
    if (typeof series.x === "string") return [Array.from(new Float32Array(bytes(series.x))), y];
    const x = [];
    for (const [length, first, step] of series.x) for (let i = 0; i < length; ++i) x.push(first + step * i);
    return [x, y];
  }

  const ascends = x => x.every((value, i) => i === 0 || value > x[i - 1]);

  // By rising x: a curve that falls throughout turned round, points in their order.
  function sorted([x, y]) {
    const order = x.map((_, i) => i).filter(i => Number.isFinite(x[i])).sort((i, k) => x[i] - x[k]);
    return [order.map(i => x[i]), order.map(i => y[i])];
  }

  // One column of x for all: as it is where the series share it, joined where not.
  function columns(all) {
    const same = all.every(([x]) => x.length === all[0][0].length && x[0] === all[0][0][0] && x[1] === all[0][0][1]);
    return same ? [all[0][0], ...all.map(one => one[1])] : uPlot.join(all);
  }

  // A curve through samples of what is limited to their band: between them the sum of their neighbours, each times a
  // sinc under a Lanczos window; straight where they are not evenly spaced, near a gap, or closer than can be seen.
  function curve(u, series, first, last) {
    const x = u.data[0], y = u.data[series], path = new Path2D(), reach = 8, near_px = 3;
    const place = (at, value) => [u.valToPos(at, "x", true), u.valToPos(value, "y", true)];
    const sinc = t => (t === 0 ? 1 : Math.sin(Math.PI * t) / (Math.PI * t));
    let down = false;
    for (let i = Math.max(0, first - 1); i <= Math.min(last + 1, x.length - 1); ++i) {
      if (y[i] == null) {
        down = false;
        continue;
      }
      const [px, py] = place(x[i], y[i]);
      down ? path.lineTo(px, py) : path.moveTo(px, py);
      down = true;
      const step = x[i + 1] - x[i], from = i - reach + 1, to = i + reach;
      const width = (u.valToPos(x[i + 1], "x", true) - px) / devicePixelRatio;
      if (!(width > near_px) || from < 0 || to >= x.length) continue;
      if (Math.abs(x[to] - x[from] - (to - from) * step) > 1e-3 * step) continue;
      if (y.slice(from, to + 1).some(value => value == null)) continue;
      const pieces = Math.ceil(width / 2);
      for (let k = 1; k < pieces; ++k) {
        let sum = 0, weights = 0;
        for (let j = from; j <= to; ++j) {
          const t = i + k / pieces - j, weight = sinc(t) * sinc(t / reach);
          sum += weight * y[j], weights += weight;
        }
        path.lineTo(...place(x[i] + step * k / pieces, sum / weights));
      }
    }
    return { stroke: path };
  }

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
    all.forEach(([x, y], k) => {
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

  function style_of(one, overlaid, is_loop) {
    const pen = () => colour(!one.dashed && !one.points && overlaid ? "under" : one.colour);
    const style = { label: one.label, stroke: pen, width: one.dashed ? 1.8 : overlaid ? 3.5 : 1.3,
                    dash: one.dashed ? [7, 4] : undefined, spanGaps: false, points: { show: one.n < 60 },
                    value: (u, v) => digits(v) };
    if (one.points)
      Object.assign(style, { paths: () => null, points: { show: true, size: one.n < 200 ? 6 : 3, width: 0, fill: pen, stroke: pen } });
    else if (is_loop)
      Object.assign(style, { paths: () => null, points: { show: false } });
    else if (one.band_limited)
      style.paths = curve;
    return style;
  }

  function draw_panel(place, chart, number, is_last, group) {
    const overlaid = chart.series.some(one => one.dashed);  // measured lies broad and grey under identified
    const all = chart.series.map(unpack).map(one => (ascends(one[0].slice().reverse()) ? sorted(one) : one));
    const data = columns(all.map(one => (ascends(one[0]) ? one : sorted(one))));
    const axis = label => ({ label: label, stroke: () => colour("ink"), grid: { stroke: () => colour("line"), width: 0.5 },
                             ticks: { stroke: () => colour("line") }, labelSize: label ? 22 : 0, labelFont: "13px sans-serif" });
    const height = () => Math.round(number > 0 ? 180 : Math.min(340, Math.max(230, 0.42 * place.clientWidth)));
    const options = {
      width: place.clientWidth, height: height(),
      scales: { x: { time: false }, y: chart.y_view ? { range: chart.y_view } : {} },
      axes: [Object.assign(axis(is_last ? chart.x_label : ""), { values: (u, ticks) => ticks.map(v => digits(v, place_digits)) }),
             Object.assign(axis(chart.y_label), { size: 62, space: number > 0 ? 20 : 30, values: (u, ticks) => ticks.map(v => digits(v)) })],
      series: [{ label: chart.x_label, value: (u, v) => digits(v, place_digits) }].concat(chart.series.map((one, k) =>
        Object.assign(style_of(one, overlaid, !ascends(all[k][0])), { label: one.label || chart.y_label }))),
      hooks: { drawClear: [shade(chart.spans)], draw: [loops(all, chart)], setSelect: [] },
      legend: { markers: { width: 2, dash: (u, i) => (i > 0 && chart.series[i - 1].dashed ? "dashed" : "solid") } },
      cursor: { drag: { x: true, y: false, setScale: false }, sync: group ? { key: group } : undefined },
    };
    const one = { chart, group, low: data[0][0], high: data[0][data[0].length - 1] };
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
    for (const other of charts) if (other === one || (one.group && other.group === one.group)) other.plot.setScale("x", { min, max });
  }

  const linked = figure => {
    const found = /^figure-(range-\d+|recording-\d+|body)/.exec(figure.getAttribute("aria-labelledby"));
    return found ? found[1] : figure.getAttribute("aria-labelledby");
  };

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
      tables.push(plot.data);
    }
    const data = uPlot.join(tables), rows = [heads.map(quoted).join(",")];
    data[0].forEach((_, i) => rows.push(data.map(column => cell(column[i])).join(",")));
    return new Blob([rows.join("\n") + "\n"], { type: "text/csv" });
  }

  function png(panels, then) {
    const all = panels.map(one => one.plot.ctx.canvas), picture = document.createElement("canvas"), ctx = picture.getContext("2d");
    picture.width = Math.max(...all.map(one => one.width));
    picture.height = all.reduce((sum, one) => sum + one.height, 0);
    ctx.fillStyle = colour("paper");
    ctx.fillRect(0, 0, picture.width, picture.height);
    let top = 0;
    for (const one of all) ctx.drawImage(one, 0, top), (top += one.height);
    picture.toBlob(then, "image/png");
  }

  const escaped = text => text.replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

  function ticks(low, high) {
    const rough = (high - low) / 6, decade = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = [1, 2, 5, 10].map(one => one * decade).find(one => one >= rough), found = [];
    for (let n = Math.ceil(low / step); n * step <= high; ++n) found.push(n * step);
    return found;
  }

  // What is shown, as lines and points of a drawing.
  function svg(panels) {
    const width = 900, heights = panels.map((_, i) => (i > 0 ? 180 : 340)), parts = [];
    let top = 0;
    panels.forEach(({ chart, plot }, number) => {
      const left = 80, right = width - 15, upper = top + 24, lower = top + heights[number] - 44;
      const { x: xs, y: ys } = plot.scales, flat = one => one.toFixed(2);
      const at = x => left + (right - left) * (x - xs.min) / (xs.max - xs.min);
      const up = y => lower - (lower - upper) * (y - ys.min) / (ys.max - ys.min);
      const text = (x, y, anchor, words, more = "") =>
        parts.push(`<text x="${flat(x)}" y="${flat(y)}" text-anchor="${anchor}"${more}>${escaped(words)}</text>`);
      parts.push(`<clipPath id="c${number}"><path d="M${left} ${upper}H${right}V${lower}H${left}Z"/></clipPath>`);
      for (const one of ticks(xs.min, xs.max)) {
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
        const [x, y] = unpack(one), ink = getComputedStyle(document.documentElement).getPropertyValue("--" + one.colour);
        let path = "", down = false;
        x.forEach((place, i) => {
          const seen = y[i] != null && place >= xs.min - (xs.max - xs.min) && place <= xs.max + (xs.max - xs.min);
          if (seen) path += (down && !one.points ? "L" : "M") + flat(at(place)) + " " + flat(up(y[i])) + (one.points ? "h0" : "");
          down = seen;
        });
        const pen = one.points ? 'stroke-width="4" stroke-linecap="round"' : one.dashed ? 'stroke-width="1.6" stroke-dasharray="6 4"' : 'stroke-width="1.3"';
        parts.push(`<path d="${path}" fill="none" stroke="${ink.trim()}" ${pen} clip-path="url(#c${number})"/>`);
        if (!one.label) return;
        text(legend, upper - 8, "start", one.label, ` fill="${ink.trim()}"`);
        legend += 7 * one.label.length + 24;
      });
      top += heights[number];
    });
    return new Blob([`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${top}" viewBox="0 0 ${width} ${top}" ` +
                     `font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>${parts.join("\n")}</svg>`],
                    { type: "image/svg+xml" });
  }

  function draw(figure) {
    const group = linked(figure), tools = figure.querySelector(".tools"), name = tools.dataset.name;
    const panels = Array.from(figure.querySelectorAll(".plot")).map((place, number, { length }) => {
      const chart = JSON.parse(place.querySelector("script").textContent);
      return draw_panel(place, chart, number, number === length - 1, chart.x_label.startsWith("time") ? group : figure.getAttribute("aria-labelledby"));
    });
    const first = panels[0], timed = first.chart.x_label.startsWith("time");
    const move = (shift, factor) => {
      const { min, max } = first.plot.scales.x, half = 0.5 * (max - min) * factor, middle = 0.5 * (min + max) + shift * (max - min);
      show(first, Math.max(first.low, middle - half), Math.min(first.high, middle + half));
    };
    add_button(tools, "zoom in", () => move(0, 0.5));
    add_button(tools, "zoom out", () => move(0, 2));
    add_button(tools, timed ? "earlier" : "left", () => move(-0.4, 1));
    add_button(tools, timed ? "later" : "right", () => move(0.4, 1));
    add_button(tools, "all", () => show(first, first.low, first.high));
    add_button(tools, "SVG", () => save(name + ".svg", svg(panels)), "save what is shown as a drawing");
    add_button(tools, "PNG", () => png(panels, blob => save(name + ".png", blob)), "save what is shown as a picture");
    add_button(tools, "CSV", () => save(name + ".csv", csv(panels)), "save the numbers of the chart");
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
    draw(figure);
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
