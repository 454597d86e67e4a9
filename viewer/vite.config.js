import {readFileSync} from 'node:fs';
import {defineConfig} from 'vite';

// Puts scripts and styles into the page itself and says what licence the libraries in it have.
const oneFile = {
  name: 'one-file',
  enforce: 'post',
  generateBundle(_options, bundle) {
    const page = bundle['index.html'];
    let html = page.source;
    for (const file of Object.values(bundle)) {
      if (file === page) continue;
      const isScript = file.type === 'chunk';
      const tag = new RegExp(isScript ? `<script[^>]*${file.fileName}[^>]*></script>`
                                      : `<link[^>]*${file.fileName}[^>]*>`);
      if (!tag.test(html)) throw new Error(`${file.fileName} is not in the page`);
      // "</script" inside a string would end the script.
      const inline = isScript ? `<script type="module">${file.code.trim().replaceAll('</script', '<\\/script')}</script>`
                              : `<style>${file.source.trim()}</style>`;
      html = html.replace(tag, () => inline);
      delete bundle[file.fileName];
    }
    const licence = readFileSync(new URL('node_modules/three/LICENSE', import.meta.url), 'utf8').trim();
    const decoder = 'and the decoder of meshoptimizer (Copyright (C) 2016-2026, by Arseny Kapoulkine), both under this licence';
    page.source = html.replace('<!doctype html>', () => `<!doctype html>\n<!-- Contains three.js ${decoder}.\n${licence}\n-->`);
  },
};

export default defineConfig({
  base: './',
  plugins: [oneFile],
  build: {target: 'es2022', modulePreload: false, assetsInlineLimit: 0, reportCompressedSize: false},
});
