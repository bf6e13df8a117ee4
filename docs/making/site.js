// What scrolls sideways can be reached, and scrolled, by the keyboard. The theme sees to this on
// machines with a mouse only, and takes the attribute away on others, at a time of its own.
const reachable = () => {
  for (const one of document.querySelectorAll(".md-typeset pre > code, .md-typeset__scrollwrap")) {
    const scrolls = one.scrollWidth > one.clientWidth;
    if (scrolls === one.hasAttribute("tabindex")) continue; // or this would answer itself for ever
    if (scrolls) one.tabIndex = 0;
    else one.removeAttribute("tabindex");
  }
};
addEventListener("load", () => {
  reachable();
  new ResizeObserver(reachable).observe(document.body);
  new MutationObserver(reachable).observe(document.body, {
    attributeFilter: ["open", "tabindex"],
    childList: true,
    subtree: true,
  });
});
