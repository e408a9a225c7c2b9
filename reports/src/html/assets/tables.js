"use strict";

/** Lets a click on a head sort the rows of each group: up, down, and as they came. What has no figure comes last. */
function makeSortable(table) {
  const heads = [...table.tHead.rows[0].cells];
  const bodies = [...table.tBodies].map((body) => ({ body, rows: [...body.rows].filter((row) => !row.classList.contains("group")) }));
  const key = (row, column) => {
    const cell = row.cells[column];
    if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
    return cell.classList.contains("none") ? null : cell.textContent.trim();
  };
  const compare = (a, b) => (typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b), "en", { numeric: true }));
  const sort = (column, way) => {
    for (const { body, rows } of bodies) {
      const keyed = rows.map((row) => ({ row, key: key(row, column) }));
      if (way !== 0) {
        keyed.sort((a, b) => {
          if (a.key === null || b.key === null) return (a.key === null) - (b.key === null);
          return way * compare(a.key, b.key);
        });
      }
      body.append(...keyed.map(({ row }) => row));
    }
  };
  heads.forEach((head, column) => {
    if (head.textContent === "") return;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    const first = head.classList.contains("n") ? "descending" : "ascending";
    const second = first === "ascending" ? "descending" : "ascending";
    button.addEventListener("click", () => {
      const now = head.getAttribute("aria-sort");
      const next = now === "none" ? first : now === first ? second : "none";
      heads.forEach((other) => other.hasAttribute("aria-sort") && other.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", next);
      sort(column, { none: 0, ascending: 1, descending: -1 }[next]);
    });
  });
}

/** Puts a field above a table that leaves the rows in which all of its words occur, in formulas too. */
function makeFilterable(scroll, table) {
  const rows = [...table.tBodies].flatMap((body) => [...body.rows]).filter((row) => !row.classList.contains("group"));
  const line = document.createElement("label");
  line.className = "filter";
  const field = Object.assign(document.createElement("input"), { type: "search", placeholder: "words of a name or formula" });
  const found = document.createElement("output");
  field.setAttribute("aria-label", `Filter: ${scroll.getAttribute("aria-label")}`);
  line.append("Filter", field, found);
  scroll.before(line);
  const texts = rows.map((row) => `${row.parentNode.querySelector(".group")?.textContent ?? ""} ${row.textContent}`.toLowerCase());
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    rows.forEach((row, index) => {
      row.hidden = !words.every((word) => texts[index].includes(word));
      shown += !row.hidden;
    });
    for (const body of table.tBodies) {
      const group = body.querySelector(".group");
      if (group) group.hidden = ![...body.rows].some((row) => row !== group && !row.hidden);
    }
    found.textContent = words.length ? `${shown} of ${rows.length}` : "";
  });
}

for (const scroll of document.querySelectorAll(".scroll")) {
  const table = scroll.querySelector("table");
  if (!table) continue;
  makeSortable(table);
  if (scroll.dataset.filter !== undefined) makeFilterable(scroll, table);
}
