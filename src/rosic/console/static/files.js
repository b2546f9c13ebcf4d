// Files: what somebody keeps here, to save and to delete.

import { dayAndTime, Nothing, Said, useAsked, useDeed } from "./asked.js";
import { html, Table, useState } from "./lib.js";
import { ask, upload } from "./store.js";
import { number, t } from "./texts.js";

const path = (file) => `/v1/files/${encodeURIComponent(file.id)}`;

/** Return a size as people read it. */
export function size(bytes) {
  if (bytes < 1000) return `${number(bytes, 0)} B`;
  return bytes < 1e6 ? `${number(bytes / 1e3, 1)} kB` : `${number(bytes / 1e6, 1)} MB`;
}

/** A file to keep: its content is sent as it is, and never opened here. */
function Upload({ act, waits, again }) {
  const send = (event) => {
    const [file] = event.target.files;
    event.target.value = "";
    if (!file) return;
    act(async () => {
      const answer = await upload(file);
      if (!answer.ok) return { kind: "bad", text: answer.why };
      return { kind: "good", text: t("{file} is kept.", { file: answer.data.name }) };
    }).then(again);
  };
  return html`<label class="button upload ${waits ? "waits" : ""}">
    ${waits ? t("Sending …") : t("Send a file")}
    <input type="file" class="hidden" disabled=${waits} onChange=${send} />
  </label>`;
}

function File({ file, act, waits, again }) {
  const [sure, askFirst] = useState(false);
  const remove = async () => {
    const answer = await ask("DELETE", path(file));
    if (!answer.ok) return { kind: "bad", text: answer.why };
    return { kind: "good", text: t("{file} is deleted, for good.", { file: file.name }) };
  };
  return html`<tr>
    <th scope="row" data-head=${t("Name")}>${file.name}</th>
    <td data-head=${t("Size")}>${size(file.size)}</td>
    <td data-head=${t("Kind")}>${file.media_type}</td>
    <td data-head=${t("Since")}>${dayAndTime(file.at)}</td>
    <td class="acts"><div class="row">
      <a class="button" href=${path(file)} download=${file.name} aria-label=${t("Save {file}", { file: file.name })}>
        ${t("Save")}
      </a>
      ${sure
        ? html`<button type="button" class="danger" disabled=${waits} onClick=${() => act(remove).then(again)}>
              ${t("Delete it for good")}
            </button>
            <button type="button" class="plain" onClick=${() => askFirst(false)}>${t("Leave it")}</button>`
        : html`<button
            type="button"
            aria-label=${t("Delete {file}", { file: file.name })}
            onClick=${() => askFirst(true)}
          >
            ${t("Delete")}
          </button>`}
    </div></td>
  </tr>`;
}

/** The tab. */
export function Files() {
  const asked = useAsked("/v1/files");
  const { said, waits, act } = useDeed();
  const files = asked.data || [];
  return html`<section class="panel" aria-labelledby="h-files">
    <div class="row week-bar">
      <h2 id="h-files">${t("My files")}</h2>
      <${Upload} act=${act} waits=${waits} again=${asked.again} />
    </div>
    ${files.length
      ? html`<${Table}
          label=${t("My files")}
          kind="stacked"
          heads=${[t("Name"), t("Size"), t("Kind"), t("Since"), html`<span class="hidden">${t("What can be done")}</span>`]}
        >
          <tbody>
            ${files.map(
              (each) =>
                html`<${File} key=${each.id} file=${each} act=${act} waits=${waits} again=${asked.again} />`,
            )}
          </tbody>
        <//>`
      : html`<${Nothing} asked=${asked} none=${t("You keep no files here yet.")} />`}
    <${Said} said=${said} />
  </section>`;
}
