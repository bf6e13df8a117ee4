document.documentElement.classList.add("js");
// What scrolls by itself can be scrolled by keys, and is named after the heading above it.
const headings = [...document.querySelectorAll("h1, h2, h3, summary")];
for (const one of document.querySelectorAll(".scroll")) {
  const follows = heading => heading.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_FOLLOWING;
  const above = headings.findLast(follows)?.textContent ?? document.title;
  one.setAttribute("role", "region");
  one.setAttribute("aria-label", above.trim().replace(/\s+/g, " "));
  one.tabIndex = 0;
}
// One of several tables at a time.
for (const picker of document.querySelectorAll(".picker")) {
  const choices = [...picker.querySelectorAll(".choice")];
  const select = picker.querySelector("select");
  const show = () => choices.forEach(one => { one.hidden = one.id !== select.value; });
  select.addEventListener("change", show);
  show();
}
// A click on a heading sorts; a second one turns the order round.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    if (!head.textContent.trim()) return;
    let button = head.querySelector("button");
    if (!button) {
      button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
    }
    button.addEventListener("click", () => {
      const falling = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(one => one.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", falling ? "descending" : "ascending");
      const value = row => {
        const told = row.cells[column].querySelector("data");
        return told ? Number(told.value) : null;
      };
      const order = (a, b) => {
        const [x, y] = [value(a), value(b)];
        if (x === null && y === null)
          return a.cells[column].textContent.localeCompare(b.cells[column].textContent) * (falling ? -1 : 1);
        if (x === null || y === null) return x === null ? 1 : -1;
        return falling ? y - x : x - y;
      };
      table.tBodies[0].append(...[...table.tBodies[0].rows].sort(order));
    });
  });
}
