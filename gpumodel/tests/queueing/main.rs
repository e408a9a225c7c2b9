mod random;
mod exact;
use random::*;
use gpumodel::queueing::*;
#[test]
fn explore() {
    let mut r = Random(1);
    let (mut worst, mut sum, mut it)=(0f64,0f64,0);
    for _ in 0..10000 {
        let n = small_network(&mut r);
        let s = solve(&n).unwrap();
        let e = exact::mva(&n);
        assert!((exact::convolution(&n)/e-1.0).abs()<1e-9);
        let d = s.throughput/e-1.0;
        sum+=d.abs(); it=it.max(s.evaluations);
        if d.abs()>worst { worst=d.abs(); println!("{d:.4} N {} Z {} D {:?} evals {} res {:e}", n.customers,n.think_time,n.stations.iter().map(|s|s.demand).collect::<Vec<_>>(), s.evaluations,s.residual);}
    }
    println!("mean {} worst {worst} it {it}", sum/1e4);
    let (mut worst, mut sum, mut it)=(0f64,0f64,0);
    for _ in 0..10000 {
        let mut n = small_network(&mut r);
        for s in &mut n.stations { s.servers = r.pick(&[1,2,4,8,16]); s.demand*=r.pick(&[1.0,f64::from(s.servers)]); }
        let s = solve(&n).unwrap();
        let e = exact::convolution(&n);
        let d = s.throughput/e-1.0;
        sum+=d.abs(); it=it.max(s.evaluations);
        if d.abs()>worst { worst=d.abs(); println!("{d:.4} N {} Z {} D {:?} evals {} res {:e}", n.customers,n.think_time,n.stations.iter().map(|s|(s.demand,s.servers)).collect::<Vec<_>>(), s.evaluations,s.residual);}
    }
    println!("mean {} worst {worst} it {it}", sum/1e4);
    let (mut worst, mut res, mut hist)=(0, 0f64, vec![0;100]);
    for _ in 0..100000 {
        let n = extreme_network(&mut r);
        let s = solve(&n).unwrap();
        res=res.max(s.residual); hist[s.evaluations as usize]+=1;
        if s.evaluations>worst { worst=s.evaluations; println!("{n:?} {s:?}");}
    }
    println!("res {res:e} {hist:?}");
}
