// What Foxglove's own reader finds in an MCAP of `pylon export`: column -> [samples, sum of the finite ones].
// Every message is checked against the JSON schema of its channel, the only source of its keys.

import { readFileSync } from "node:fs";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import Ajv from "ajv";

const [file] = process.argv.slice(2);
const bytes = readFileSync(file);
const schemas = new Map();
const channels = new Map();
const counts = {};
// Messages of Foxglove's own schema, which its map shows; their numbers repeat the columns'.
const fixes = [];
let messages = 0;

function take(schema, channel, message) {
  let known = schemas.get(schema.id);
  if (known === undefined) {
    if (schema.encoding !== "jsonschema" || channel.messageEncoding !== "json") {
      throw new Error(`${channel.topic}: ${schema.encoding}, ${channel.messageEncoding}`);
    }
    const definition = JSON.parse(new TextDecoder().decode(schema.data));
    known = { check: new Ajv({ strict: true, allowUnionTypes: true }).compile(definition), names: Object.keys(definition.properties) };
    schemas.set(schema.id, known);
  }
  const value = JSON.parse(new TextDecoder().decode(message.data));
  if (!known.check(value)) {
    throw new Error(`${channel.topic}: not by its schema: ${JSON.stringify(known.check.errors)}`);
  }
  messages += 1;
  if (schema.name === "foxglove.LocationFix") {
    fixes.push(value);
    return;
  }
  for (const name of Object.keys(value)) {
    if (!known.names.includes(name)) {
      throw new Error(`${channel.topic}: ${name} is not in its schema`);
    }
    const [samples, sum] = counts[name] ?? [0, 0];
    counts[name] = [samples + 1, sum + (value[name] ?? 0)];
  }
}

// Read by the index at the end, as Foxglove opens a file.
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  },
});
for (const channel of reader.channelsById.values()) {
  channels.set(channel.topic, reader.schemasById.get(channel.schemaId).name);
}
const metadata = [];
for await (const record of reader.readMetadata()) {
  metadata.push([record.name, Object.fromEntries(record.metadata)]);
}
let last = -1n;
for await (const message of reader.readMessages()) {
  if (message.logTime < last) {
    throw new Error("messages go back in time");
  }
  last = message.logTime;
  const channel = reader.channelsById.get(message.channelId);
  take(reader.schemasById.get(channel.schemaId), channel, message);
}

// Read from the beginning with its checksums, as a stream.
const stream = new McapStreamReader({ validateCrcs: true });
stream.append(bytes);
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) {
  streamed += record.type === "Message" ? 1 : 0;
}
if (!stream.done() || streamed !== messages) {
  throw new Error(`${streamed} messages from the beginning, ${messages} by the index`);
}
process.stdout.write(JSON.stringify({ counts, fixes, channels: Object.fromEntries(channels), metadata, messages }));
