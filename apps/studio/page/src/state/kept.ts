// What survives a reload: the logs and the session, in this browser and nowhere else.

const NAME = "pylon-studio";
const LOGS = "logs";
const SESSION = "session";

let opened: Promise<IDBDatabase> | undefined;

function database(): Promise<IDBDatabase> {
  opened ??= new Promise((done, failed) => {
    const request = indexedDB.open(NAME, 1);
    request.onupgradeneeded = () => {
      request.result.createObjectStore(LOGS);
      request.result.createObjectStore(SESSION);
    };
    request.onsuccess = () => done(request.result);
    request.onerror = () => failed(request.error ?? new Error("the browser keeps nothing"));
  });
  return opened;
}

async function put(store: string, key: string, value: unknown): Promise<void> {
  const base = await database();
  return new Promise((done, failed) => {
    const change = base.transaction(store, "readwrite");
    change.objectStore(store).put(value, key);
    change.oncomplete = () => done();
    change.onerror = () => failed(change.error ?? new Error("the browser has no room"));
    change.onabort = () => failed(change.error ?? new Error("the browser has no room"));
  });
}

async function get(store: string, key: string): Promise<unknown> {
  const base = await database();
  return new Promise((done, failed) => {
    const request: IDBRequest<unknown> = base.transaction(store).objectStore(store).get(key);
    request.onsuccess = () => done(request.result);
    request.onerror = () => failed(request.error ?? new Error("the browser does not give it back"));
  });
}

async function remove(store: string, key: string): Promise<void> {
  const base = await database();
  base.transaction(store, "readwrite").objectStore(store).delete(key);
}

export async function keepLog(id: string, blob: Blob): Promise<void> {
  await put(LOGS, id, blob);
}

export async function keptLog(id: string): Promise<Blob | null> {
  const found = await get(LOGS, id);
  return found instanceof Blob ? found : null;
}

export async function dropLog(id: string): Promise<void> {
  await remove(LOGS, id);
}

export async function keepSession(session: unknown): Promise<void> {
  await put(SESSION, "last", session);
}

/** The session as it was written, by this release of the page or another. */
export async function keptSession(): Promise<unknown> {
  return get(SESSION, "last");
}
