// The data files that can be opened, in groups.
(function () {
  "use strict";
  const { html } = window.mcdas;

  window.mcdas.fillFiles = (select, groups) => {
    for (const { label, kind, names } of groups) {
      if (!names.length) continue;
      const group = html("optgroup", "", select);
      group.label = label;
      for (const name of names) Object.assign(html("option", "", group, name).dataset, { kind, name });
    }
  };
})();
