// node run.mjs URL REQUEST.json: prints what the compiled client found.
import { readFileSync } from 'node:fs'
import { find } from './out/client.js'

const [url, request] = process.argv.slice(2)
console.log(JSON.stringify(await find(url, JSON.parse(readFileSync(request, 'utf8')))))
