import { defineConfig, loadEnv, type Plugin, type ProxyOptions } from "vite";

/** Adds a gzip of each text of the page: the monitor sends it to browsers that read it. */
const gzip: Plugin = {
  name: "gzip",
  apply: "build",
  enforce: "post",
  generateBundle: {
    // The page itself comes last.
    order: "post",
    async handler(_, bundle) {
      for (const file of Object.values(bundle).filter(({ fileName }) => /\.(html|js|css)$/.test(fileName))) {
        const text = new Blob([file.type === "chunk" ? file.code : (file.source as BlobPart)]);
        const packed = new Response(text.stream().pipeThrough(new CompressionStream("gzip")));
        const source = new Uint8Array(await packed.arrayBuffer());
        this.emitFile({ type: "asset", fileName: `${file.fileName}.gz`, source });
      }
    },
  },
};

/** The monitor whose cell or recording `npm run dev` shows. */
const target = loadEnv("", ".", "ROBOCELL_").ROBOCELL_MONITOR ?? "http://127.0.0.1:8600";

/** The monitor answers its own origin only; here, nothing but the page of this server is taken for it. */
const monitor: ProxyOptions = {
  target,
  changeOrigin: true,
  headers: { origin: target },
  bypass: ({ headers: { host, origin } }) => (origin === undefined || origin === `http://${host}` ? undefined : false),
};

// The page is served by the monitor from its own origin: no path outside of it.
export default defineConfig({
  base: "./",
  build: {
    outDir: "dist",
    target: "es2022",
    chunkSizeWarningLimit: 1500,
    // A copy of the page must carry the notices of the packages in it.
    license: { fileName: "licences.md" },
  },
  plugins: [gzip],
  server: {
    // The monitor's cookie is one of this address.
    host: "127.0.0.1",
    proxy: { "/ws": { ...monitor, ws: true }, "^/(api|meshes)/": monitor, "^/\\?token=": monitor },
  },
});
