// Tabs: one of them is open, and the arrow keys go round those that are there.

// Marks the tab that is open, the only one that the keyboard reaches.
export function marked(tabs, open) {
  for (const tab of tabs) { tab.setAttribute("aria-selected", tab === open); tab.tabIndex = tab === open ? 0 : -1; }
}

// Opens the tab next to one that has the cursor, if the key is an arrow.
export function turned(key, tab, tabs) {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[key], there = tabs.filter((other) => !other.hidden);
  if (!step) return;
  const next = there[(there.indexOf(tab) + step + there.length) % there.length];
  next.click(); next.focus();
}
