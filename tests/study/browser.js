// Runs in the page, inside a frame, and reports errors to the page around it.
"use strict";
addEventListener("load", () => {
  const wrong = [];
  const expect = (right, what) => { if (!right) wrong.push(what); };
  const root = document.documentElement;
  try {
    const drawings = [...document.querySelectorAll("svg")];
    // The first page has two charts, and the appendix all others.
    const isAnswer = document.title.startsWith("Which");
    expect(isAnswer ? drawings.length === 2 : drawings.length > 20, `${drawings.length} drawings`);
    const empty = drawings.filter((svg) => {
      const { width, height } = svg.getBoundingClientRect();
      return width < 100 || height < 100;
    });
    expect(!empty.length, `${empty.length} drawings without a size`);
    const isBeyond = (element) => element.getBoundingClientRect().right > innerWidth;
    const beyond = [...document.querySelectorAll("body *")].filter(isBeyond);
    const widest = beyond.find((element) => !element.closest(".table, .chart"))?.outerHTML.slice(0, 100);
    expect(root.scrollWidth <= innerWidth, `wider than the window: ${root.scrollWidth} of ${innerWidth}, ${widest}`);
    expect(drawings[0].getAttribute("aria-label").length > 10, "no label");
    const isOpen = document.querySelector("nav details").open;
    expect(isOpen === innerWidth >= 1024, "the contents must be open in wide windows only");

    const pointAt = (mark, share) => {
      mark.scrollIntoView({ block: "center" });
      const box = mark.getBoundingClientRect();
      const [clientX, clientY] = [box.left + share * box.width, box.top + share * box.height];
      mark.dispatchEvent(new PointerEvent("pointerover", { bubbles: true, clientX, clientY }));
      const tip = document.getElementById("tip");
      const { left, right, top, bottom } = tip.getBoundingClientRect();
      const within = left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight && bottom > top;
      expect(within, `no tip within the window: ${[left, top, right, bottom]}`);
      return tip.textContent;
    };
    // What the tips of some marks must say. Marks with the same figures share a line of the tip. Marks within a few
    // pixels add lines.
    const all = [...document.querySelectorAll(".hover > *")];
    const says = (what) => all.find((mark) => what.test(mark.dataset.title ?? mark.textContent));
    const answer = [
      /^triangle\/\w+, primary: [\d,.]+ \([\d,.]+ to [\d,.]+\) M rays\/s, geometric mean of the scenes$/m,
      /^triangle\/\w+, false, aimed at edges: [\d,.]+( \(< [\d.,]+\))? per million, n = \d/m,
      /^triangle\/\w+, 8x1: [\d,.]+ \([\d,.]+ to [\d,.]+\) M tests\/s$/m,
      /^triangle\/\w+, leaks [\d,.]+( \(< [\d.,]+\))? per million, n = \d/m,
      /^quadric\/\w+, 1x1: [\d,.]+ \([\d,.]+ to [\d,.]+\) M tests\/s$/m,
    ];
    const appendix = [
      /^aabb\/\w+.*, scalar and packet, at 1e-\d: lost [\d,.]+( \(< [\d.,]+\))? per million, n = \d/m,
      /^(\w+, )*packet, (\w+, )*jitter 0.1: [\d,.]+ M rays\/s$/m,
    ];
    for (const what of isAnswer ? answer : appendix) {
      const mark = says(what);
      expect(mark && what.test(pointAt(mark, 0.5)), `no tip ${what}`);
      const others = [...(mark?.ownerSVGElement.querySelectorAll("svg > g[data-of]") ?? [])];
      const meant = mark?.dataset.of.split(" ");
      const isMeant = (group) => group.dataset.of.split(" ").some((of) => meant.includes(of));
      const isRight = (group) => (getComputedStyle(group).opacity < 1) !== isMeant(group);
      expect(others.length && others.every(isRight), "other series are not dimmed, or the same one is");
    }
    const map = isAnswer ? undefined : says(/^triangle\/\w+, scalar and packet, number of cells by error of t: .+: \d+/);
    if (map) {
      const cells = [0.01, 0.99].map((share) => pointAt(map, share));
      expect(/\n→ .+: \S+\n↑ .+: \S+\n.+/.test(cells[0]) && cells[0] !== cells[1], `cells: ${cells}`);
    }
    expect(isAnswer || map, "no failure map");

    document.body.dispatchEvent(new PointerEvent("pointerover", { bubbles: true }));
    expect(document.getElementById("tip").hidden && !document.querySelector(".pointed"), "the tip does not disappear");
    drawings[0].dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    expect(!document.getElementById("tip").hidden, "no tip for the arrow keys");
  } catch (error) {
    wrong.push(`error: ${error.message}`);
  }
  const loaded = performance.getEntriesByType("resource").map((entry) => entry.name);
  const errors = window.errors.map((error) => `error: ${error}`);
  if (loaded.length || errors.some((error) => error.includes("refused"))) wrong.push(`loaded or refused: ${loaded}`);
  wrong.push(...errors);
  parent.postMessage(wrong.join("; ") || "ok", "*");
});
