// SPDX-License-Identifier: GPL-3.0-or-later
// usage: node build.js OUT.cpp    bundles script and style and writes them as C++ text (host/report/page/page_assets.hpp)
import {writeFileSync} from 'node:fs';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const options = {
  bundle: true,
  minify: true,
  write: false,
  charset: 'ascii',
  legalComments: 'inline',
  logLevel: 'warning',
  absWorkingDir: fileURLToPath(new URL('.', import.meta.url)),
};
const script = await build({...options, entryPoints: ['main.js'], format: 'iife', target: ['chrome100', 'firefox100', 'safari15.4']});
const style = await build({...options, entryPoints: ['style.css']});

// In pieces, for a compiler need not take a literal longer than 65,536 characters.
function literal(text) {
  const bytes = Buffer.from(text, 'utf8');
  const lines = [];
  for (let start = 0; start < bytes.length; start += 4096) {
    let line = '';
    for (const byte of bytes.subarray(start, start + 4096)) {
      const c = String.fromCharCode(byte);
      if (c === '"' || c === '\\' || c === '?') line += '\\' + c;
      else if (byte >= 0x20 && byte < 0x7f) line += c;
      else line += '\\' + byte.toString(8).padStart(3, '0');
    }
    lines.push(`    "${line}"`);
  }
  return lines.join('\n');
}

const end = '</script';
for (const file of [...script.outputFiles, ...style.outputFiles])
  if (file.text.toLowerCase().includes(end)) throw new Error(`${file.path} holds ${end}, which would end the page's script`);
writeFileSync(process.argv[2], `// SPDX-License-Identifier: GPL-3.0-or-later
// Written by host/report/page/browser/build.js.
#include "host/report/page/page_assets.hpp"

namespace tetragauge {

const std::string_view kPageStyle =
${literal(style.outputFiles[0].text)};

const std::string_view kPageScript =
${literal(script.outputFiles[0].text)};

}  // namespace tetragauge
`);
