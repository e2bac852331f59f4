// Uses the menu of the page, and posts what is seen to the parent frame as JSON.
addEventListener("load", () => {
  const all = (query) => [...document.querySelectorAll(query)];
  const box = (e) => e.getBoundingClientRect();
  const seen = (e) => box(e).width > 0 && box(e).height > 0;
  const height = document.documentElement.scrollHeight;
  const heads = () => all("thead th").filter(seen);
  const columns = () => heads().filter((e) => e.className).length;
  const curves = () => all(".own path:not(.dots)").filter(seen).length;
  const first = { columns: columns(), curves: curves(), incidence: heads()[0].textContent };
  const wide = all("body *")
    .filter((e) => !e.closest(".scroll, svg") && box(e).right > innerWidth + 0.5)
    .map((e) => `${e.tagName}.${e.className}`);
  const scrolled = all(".scroll").filter(seen);
  const beyond = Math.max(...scrolled.map((e) => e.scrollWidth - e.clientWidth));
  const parts = (colour) => colour.match(/[\d.]+/g).map(Number);
  const luminance = (colour) => {
    const [r, g, b] = parts(colour).map((v) => {
      const s = v / 255;
      return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = luminance(getComputedStyle(document.body).backgroundColor);
  const texts = all("body *").filter(
    (e) => seen(e) && [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()),
  );
  const contrast = (e) => {
    const style = getComputedStyle(e);
    const own = luminance(e.closest("svg") ? style.fill : style.color);
    return (Math.max(own, ground) + 0.05) / (Math.min(own, ground) + 0.05);
  };
  const broken = all("img").filter((image) => !image.complete || image.naturalWidth === 0).length;
  document.getElementById("s1").click();
  const second = { columns: columns(), curves: curves() };
  document.getElementById("i1").click();
  const third = { columns: columns(), incidence: heads()[0].textContent };
  parent.postMessage(
    JSON.stringify({
      wide,
      height,
      beyond,
      broken,
      least_contrast: Math.min(...texts.map(contrast)),
      columns: [first.columns, second.columns, third.columns],
      curves: [first.curves, second.curves],
      incidences: [first.incidence, third.incidence],
    }),
    "*",
  );
});
