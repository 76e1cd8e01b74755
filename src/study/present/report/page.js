"use strict";
(() => {
  // The contents are open beside the text, and closed above it.
  const wide = matchMedia("(min-width: 64rem)");
  const contents = document.querySelector("nav details");
  const fold = () => { contents.open = wide.matches; };
  wide.addEventListener("change", fold);
  fold();

  const tip = document.createElement("div");
  tip.id = "tip";
  tip.hidden = true;
  tip.setAttribute("role", "status");
  document.body.append(tip);
  let pointed = null;

  // The tip below replaces the tooltip of the browser, so the title is moved to a data attribute.
  const titleOf = (mark) => {
    const title = mark.querySelector("title");
    if (title) {
      mark.dataset.title = title.textContent;
      title.remove();
    }
    return mark.dataset.title;
  };

  // For a failure map: the text about the cell under the pointer.
  const cellOf = (mark, x, y) => {
    const { axes, cells } = mark.dataset;
    if (!cells) return "";
    const [xs, ys] = [mark.dataset.x, mark.dataset.y].map((steps) => steps.split(" "));
    const box = mark.getBoundingClientRect();
    const index = (share, count) => Math.min(Math.max(Math.floor(share * count), 0), count - 1);
    const column = index((x - box.left) / box.width, xs.length);
    const row = index((box.bottom - y) / box.height, ys.length);
    const figure = cells.split(" ")[row * xs.length + column];
    const [xAxis, yAxis] = axes.split("|");
    const isNumber = /^\d+$/.test(figure);
    const what = isNumber ? `99th percentile of the error of t: ${Number(figure).toLocaleString("en")} ulp` : figure;
    return `\n→ ${xAxis}: ${xs[column]}\n↑ ${yAxis}: ${ys[row]}\n${what}`;
  };

  const leave = () => {
    tip.hidden = true;
    if (!pointed) return;
    const svg = pointed.ownerSVGElement;
    svg.classList.remove("pointed");
    svg.querySelectorAll(".meant").forEach((element) => element.classList.remove("meant"));
    pointed = null;
  };

  const point = (mark, x, y) => {
    if (mark !== pointed) {
      leave();
      pointed = mark;
      const svg = mark.ownerSVGElement;
      const subjects = mark.dataset.of.split(" ");
      for (const group of svg.querySelectorAll("g[data-of]")) {
        group.classList.toggle("meant", group.dataset.of.split(" ").some((of) => subjects.includes(of)));
      }
      svg.classList.add("pointed");
      mark.classList.add("meant");
    }
    tip.textContent = titleOf(mark) + cellOf(mark, x, y);
    tip.hidden = false;
    const { width, height } = tip.getBoundingClientRect();
    const [right, bottom] = [document.documentElement.clientWidth, innerHeight];
    const left = x + 14 + width > right ? x - 14 - width : x + 14;
    const top = y + 14 + height > bottom ? y - 14 - height : y + 14;
    tip.style.left = `${Math.max(4, Math.min(left, right - width - 4))}px`;
    tip.style.top = `${Math.max(4, top)}px`;
  };

  const pointAt = (event) => {
    const mark = event.target.closest?.(".hover > *");
    if (mark) point(mark, event.clientX, event.clientY);
    else leave();
  };
  for (const event of ["pointerover", "pointermove", "pointerdown"]) document.addEventListener(event, pointAt);
  document.addEventListener("scroll", leave, { passive: true });

  // While a chart has the focus, the arrow keys go from mark to mark.
  for (const svg of document.querySelectorAll(".chart svg")) {
    const marks = svg.querySelectorAll(".hover > *");
    if (!marks.length) continue;
    let current = -1;
    svg.tabIndex = 0;
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (event.key === "Escape") leave();
      if (!step) return;
      event.preventDefault();
      current = (current + step + marks.length) % marks.length;
      const box = marks[current].getBoundingClientRect();
      point(marks[current], box.left + box.width / 2, box.top + box.height / 2);
    });
    svg.addEventListener("blur", leave);
  }
})();
