// Sets the formulas of a page, which are in it as TeX.
document.addEventListener("DOMContentLoaded", () => {
  for (const place of document.querySelectorAll(".formula"))
    katex.render(place.textContent, place, {displayMode: place.tagName === "DIV", throwOnError: false});
});
