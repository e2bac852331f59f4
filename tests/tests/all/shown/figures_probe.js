// Posts, for each figure, the texts that leave it and the pairs that cover each other, each with
// the number of pixels.
addEventListener("load", () => {
  // Letters fill a part of the box of a line: 0.8 of the size above its base, 0.24 below.
  const box = (text) => {
    const size = parseFloat(getComputedStyle(text).fontSize);
    const own = text.getBBox();
    const [x, y] = [own.x, Number(text.getAttribute("y") || 0)];
    const corners = [
      [x, y - 0.8 * size],
      [x + own.width, y + 0.24 * size],
    ];
    const matrix = text.getCTM();
    const places = corners.map(([x, y]) => new DOMPoint(x, y).matrixTransform(matrix));
    const along = (key) => places.map((p) => p[key]).sort((a, b) => a - b);
    return { name: text.textContent, x: along("x"), y: along("y") };
  };
  const figures = [...document.querySelectorAll("svg")].map((svg) => {
    const texts = [...svg.querySelectorAll("text")].map(box);
    const { width, height } = svg.viewBox.baseVal;
    const outside = texts.map(({ name, x, y }) => ({
      name,
      by: Math.max(-x[0], -y[0], x[1] - width, y[1] - height),
    }));
    const covered = [];
    texts.forEach((a, k) => {
      for (const b of texts.slice(0, k)) {
        const shared = (key) => Math.min(a[key][1], b[key][1]) - Math.max(a[key][0], b[key][0]);
        covered.push({ name: `${a.name} and ${b.name}`, by: Math.min(shared("x"), shared("y")) });
      }
    });
    const real = (fault) => fault.by > 0;
    return {
      texts: texts.length,
      outside: outside.filter(real),
      covered: covered.filter(real),
    };
  });
  parent.postMessage(JSON.stringify(figures), "*");
});
