// Draws every figure that carries its numbers (chart_data.cpp writes them); without scripts the page keeps its tables.
"use strict";
(function () {
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;

  function unpack(series) {
    const codes = new Int16Array(bytes(series.y)), y = new Array(series.n), x = new Array(series.n);
    const given = series.x === undefined ? null : new Float32Array(bytes(series.x));
    for (let i = 0; i < series.n; ++i) {
      y[i] = codes[i] === -32768 ? null : series.middle + series.step * codes[i];
      x[i] = given ? given[i] : series.x0 + series.dx * i;
    }
    return [x, y];
  }

  // One column of x for all: as it is where the series share it, joined where not.
  function columns(all) {
    const same = all.every(([x]) => x.length === all[0][0].length && x[0] === all[0][0][0] && x[1] === all[0][0][1]);
    return same ? [all[0][0], ...all.map(one => one[1])] : uPlot.join(all);
  }

  function shade(spans) {
    return u => {
      const { ctx, bbox } = u, room = 4 * devicePixelRatio;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
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
      ctx.restore();
    };
  }

  const digits = (value, most = 4) => value == null ? "-" : Number(value.toPrecision(most)).toString();
  const place_digits = 8;  // of an abscissa: milliseconds of a day

  function draw(figure) {
    const chart = JSON.parse(figure.querySelector("script").textContent), place = figure.querySelector(".plot");
    const overlaid = chart.series.some(one => one.dashed);  // measured lies broad and grey under identified
    const data = columns(chart.series.map(unpack));
    const axis = label => ({ label: label, stroke: () => colour("ink"), grid: { stroke: () => colour("line"), width: 0.5 },
                             ticks: { stroke: () => colour("line") }, labelSize: 22, labelFont: "13px sans-serif" });
    const height = () => Math.round(Math.min(340, Math.max(230, 0.5 * place.clientWidth)));
    const options = {
      width: place.clientWidth, height: height(),
      scales: { x: { time: false } },
      axes: [Object.assign(axis(chart.x_label), { values: (u, ticks) => ticks.map(v => digits(v, place_digits)) }),
             Object.assign(axis(chart.y_label), { size: 62, values: (u, ticks) => ticks.map(v => digits(v)) })],
      series: [{ label: chart.x_label, value: (u, v) => digits(v, place_digits) }].concat(chart.series.map(one => ({
        label: one.label || chart.y_label, stroke: () => colour(!one.dashed && overlaid ? "under" : one.colour),
        width: one.dashed ? 1.8 : overlaid ? 3.5 : 1.3,
        dash: one.dashed ? [7, 4] : undefined, spanGaps: false, points: { show: one.n < 60 },
        value: (u, v) => digits(v) }))),
      hooks: { drawClear: [shade(chart.spans)] },
      legend: { markers: { width: 2, dash: (u, i) => (i > 0 && chart.series[i - 1].dashed ? "dashed" : "solid") } },
      cursor: { drag: { x: true, y: false } },
    };
    const plot = new uPlot(options, data, place), low = data[0][0], high = data[0][data[0].length - 1];
    const move = (shift, factor) => {
      const { min, max } = plot.scales.x, half = 0.5 * (max - min) * factor, middle = 0.5 * (min + max) + shift * (max - min);
      plot.setScale("x", { min: Math.max(low, middle - half), max: Math.min(high, middle + half) });
    };
    if (chart.view) plot.setScale("x", { min: chart.view[0], max: chart.view[1] });
    const acts = { "zoom in": () => move(0, 0.5), "zoom out": () => move(0, 2), "earlier": () => move(-0.4, 1),
                   "later": () => move(0.4, 1), "all": () => plot.setScale("x", { min: low, max: high }) };
    const tools = figure.querySelector(".tools");
    for (const name of Object.keys(acts)) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = chart.x_label.startsWith("time") ? name : name.replace("earlier", "left").replace("later", "right");
      button.addEventListener("click", acts[name]);
      tools.appendChild(button);
    }
    new ResizeObserver(() => {
      if (place.clientWidth > 0 && place.clientWidth !== plot.width) plot.setSize({ width: place.clientWidth, height: height() });
    }).observe(place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plot.redraw());
  }

  // On paper nothing can be opened: what is folded is printed, but for the numbers of figures.
  const folded = () => document.querySelectorAll("section > details:not([open])");
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = Array.from(folded());
    opened.forEach(one => (one.open = true));
  });
  addEventListener("afterprint", () => opened.forEach(one => (one.open = false)));

  const waiting = Array.from(document.querySelectorAll("figure.chart"));
  (function next() {
    const figure = waiting.shift();
    if (!figure) {
      document.documentElement.dataset.drawn = "all";
      return;
    }
    draw(figure);
    setTimeout(next, 0);
  })();
})();
