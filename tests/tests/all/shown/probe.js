// Measures the page after its layout and posts the figures to the parent frame as JSON.
addEventListener("load", async () => {
  const folds = [...document.querySelectorAll("details")];
  const folded = folds.filter((fold) => !fold.open).length;
  // All that folds out is measured too.
  for (const fold of folds) fold.open = true;
  const all = [...document.body.querySelectorAll("*")].filter((e) => e.tagName !== "SCRIPT");
  const box = (e) => e.getBoundingClientRect();
  const free = all.filter((e) => !e.parentElement.closest(".scroll, svg"));
  const wide = free.filter((e) => box(e).right > innerWidth + 0.5 || box(e).left < -0.5);
  const charts = all.filter((e) => e.matches("figure > svg"));
  const size = (e) => {
    const svg = e.closest("svg");
    const scale = svg ? box(svg).width / svg.viewBox.baseVal.width : 1;
    return parseFloat(getComputedStyle(e).fontSize) * scale;
  };
  const texts = all.filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()));
  // Relative luminance and contrast as WCAG defines them. An element without a background has that
  // of the nearest ancestor with one.
  const parts = (colour) => colour.match(/[\d.]+/g).map(Number);
  const luminance = (colour) => {
    const [r, g, b] = parts(colour).map((v) => {
      const s = v / 255;
      return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (e) => {
    const colour = getComputedStyle(e).backgroundColor;
    const [, , , alpha = 1] = parts(colour);
    return alpha === 0 && e.parentElement ? ground(e.parentElement) : colour;
  };
  const contrast = (e) => {
    const style = getComputedStyle(e);
    const [a, b] = [luminance(e.closest("svg") ? style.fill : style.color), luminance(ground(e))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };
  let broken = 0;
  for (const image of document.querySelectorAll("svg image")) {
    const copy = new Image();
    copy.src = image.getAttribute("href");
    await copy.decode().catch(() => (broken += 1));
  }
  const figures = {
    window: innerWidth,
    folded,
    page: document.documentElement.scrollWidth,
    wide: wide.map((e) => `${e.tagName}.${e.className}`),
    smallest_chart: Math.min(...charts.map((e) => Math.min(box(e).width, box(e).height))),
    smallest_text: Math.min(...texts.map(size)),
    least_contrast: Math.min(...texts.map(contrast)),
    dark: luminance(ground(document.body)) < 0.2,
    captures: document.querySelectorAll("figure.capture > svg").length,
    broken_images: broken,
  };
  parent.postMessage(JSON.stringify(figures), "*");
});
